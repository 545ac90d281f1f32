#include "mlic_core/crossmodal/view_selection.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "mlic_core/common/order_statistics.h"
#include "mlic_core/common/parallel.h"

namespace mlic {
namespace {

constexpr int kColumns = 10, kRows = 8;   // parts of the image; from: structural
constexpr double kSmallWidth = 200.0;     // px, of the drawing that is judged; from: guard, time
constexpr double kMatchSigma = 0.5;       // px, of a match in a part full of structure
constexpr float kStrongGradient = 0.03f;  // of brightness between pixels of the small drawing
constexpr float kDepthStep = 0.1f;        // share of the depth: an edge
constexpr double kLeastStructure = 0.1;
constexpr int kFewestParts = 4;  // with structure, of a view worth matching; from: guard, of 80
constexpr double kPlace = 1.0;   // m: matches within one cube share the map's error
// What is known before: rotation rad, translation m, focal length, centre, distortion. from: guard, wide:
// keeps the determinant of the information from zero.
constexpr double kRotationSigma = 0.02, kTranslationSigma = 0.1, kFocalSigma = 0.02, kCentreSigma = 0.02,
                 kDistortionSigma = 0.1;

using PlaceKey = std::tuple<int, int, int>;

// What one part of a view would tell.
struct Part {
  Eigen::MatrixXd information;  // of rotation, translation and intrinsics
  PlaceKey place;
};

Part PartAt(const CameraIntrinsics& intrinsics, const RigidTransform& T_map_camera,
            const Eigen::Vector2d& pixel, double depth, double weight) {
  Part part;
  Eigen::Vector3d bearing;
  Eigen::Vector2d again;
  CameraPointJacobian J_point;
  CameraParameterJacobian J_parameters;
  if (!Unproject(intrinsics, pixel, &bearing)) return part;
  const Eigen::Vector3d p = depth * bearing, p_in_map = T_map_camera * p;
  if (!Project(intrinsics, p, &again, &J_point, &J_parameters)) return part;
  Eigen::MatrixXd J(2, 6 + J_parameters.cols());
  for (int a = 0; a < 3; ++a) J.col(a) = J_point * Eigen::Vector3d::Unit(a).cross(p);
  J.middleCols<3>(3) = J_point;
  J.rightCols(J_parameters.cols()) = J_parameters;
  part.information = weight / (kMatchSigma * kMatchSigma) * J.transpose() * J;
  part.place = {static_cast<int>(std::floor(p_in_map.x() / kPlace)),
                static_cast<int>(std::floor(p_in_map.y() / kPlace)),
                static_cast<int>(std::floor(p_in_map.z() / kPlace))};
  return part;
}

// Pixels of the small drawing that show structure: steps of brightness or of depth.
bool HasStructure(const RenderedView& view, int column, int row) {
  const float here = view.intensity.at<float>(row, column), depth = view.depth.at<float>(row, column);
  for (const auto& [dx, dy] : {std::pair<int, int>{1, 0}, std::pair<int, int>{0, 1}}) {
    const int x = column + dx, y = row + dy;
    if (x >= view.depth.cols || y >= view.depth.rows || !view.IsSeen(x, y)) continue;
    if (std::abs(view.intensity.at<float>(y, x) - here) > kStrongGradient) return true;
    if (std::abs(view.depth.at<float>(y, x) - depth) > kDepthStep * depth) return true;
  }
  return false;
}

std::vector<Part> PartsOf(const CameraIntrinsics& intrinsics, const ViewCandidate& candidate,
                          const RenderedView& view) {
  std::vector<Part> parts;
  const int width = view.depth.cols, height = view.depth.rows;
  const double scale = static_cast<double>(width) / intrinsics.width;
  for (int part = 0; part < kColumns * kRows; ++part) {
    const int first_column = part % kColumns * width / kColumns,
              last_column = (part % kColumns + 1) * width / kColumns;
    const int first_row = part / kColumns * height / kRows, last_row = (part / kColumns + 1) * height / kRows;
    int seen = 0, strong = 0;
    std::vector<float> depths;
    Eigen::Vector2d middle = Eigen::Vector2d::Zero();
    for (int row = first_row; row < last_row; ++row) {
      for (int column = first_column; column < last_column; ++column) {
        if (!view.IsSeen(column, row)) continue;
        ++seen;
        if (!HasStructure(view, column, row)) continue;
        ++strong;
        depths.push_back(view.depth.at<float>(row, column));
        middle += Eigen::Vector2d(column, row);
      }
    }
    const double area = (last_column - first_column) * (last_row - first_row);
    const double structure = std::min(1.0, 4.0 * strong / area);
    if (seen < 0.5 * area || structure < kLeastStructure) continue;
    const Eigen::Vector2d pixel = ((middle / strong).array() + 0.5) / scale - 0.5;
    Part found = PartAt(intrinsics, candidate.pose.T_map_camera(pixel.y()), pixel, Median(std::move(depths)),
                        candidate.quality * structure);
    if (found.information.size() > 0) parts.push_back(std::move(found));
  }
  if (parts.size() < kFewestParts) parts.clear();
  return parts;
}

Eigen::MatrixXd PriorInformation(const CameraIntrinsics& intrinsics) {
  const int n = 6 + static_cast<int>(intrinsics.parameters.size());
  Eigen::VectorXd sigma = Eigen::VectorXd::Constant(n, kDistortionSigma);
  sigma.head<3>().setConstant(kRotationSigma);
  sigma.segment<3>(3).setConstant(kTranslationSigma);
  sigma.segment<2>(6).setConstant(kFocalSigma * intrinsics.parameters[0]);
  sigma.segment<2>(8).setConstant(kCentreSigma * intrinsics.width);
  return sigma.array().square().inverse().matrix().asDiagonal();
}

double LogDeterminant(const Eigen::MatrixXd& information) {
  return 2.0 * information.llt().matrixLLT().diagonal().array().log().sum();
}

}  // namespace

CameraIntrinsics ScaledIntrinsics(const CameraIntrinsics& intrinsics, double scale) {
  CameraIntrinsics scaled = intrinsics;
  scaled.width = static_cast<int>(std::lround(scale * intrinsics.width));
  scaled.height = static_cast<int>(std::lround(scale * intrinsics.height));
  for (int k = 0; k < 2; ++k) {
    scaled.parameters[k] *= scale;
    // Pixel centres are at whole numbers, the image's corner at (-0.5, -0.5).
    scaled.parameters[2 + k] = (intrinsics.parameters[2 + k] + 0.5) * scale - 0.5;
  }
  return scaled;
}

std::vector<std::size_t> SelectViews(const IntensityMap& map, const CameraIntrinsics& intrinsics,
                                     const std::vector<ViewCandidate>& candidates,
                                     const ViewSelectionOptions& options) {
  const std::size_t count = std::min(candidates.size(), options.most_candidates);
  const CameraIntrinsics small = ScaledIntrinsics(intrinsics, std::min(1.0, kSmallWidth / intrinsics.width));
  const double row_scale = static_cast<double>(intrinsics.height) / small.height;
  const ViewRenderer renderer(map, small, {});
  std::vector<std::vector<Part>> parts(count);
  std::vector<std::size_t> indices(count);
  ParallelFor(count, [&](std::size_t k) {
    indices[k] = k * candidates.size() / count;
    const ViewCandidate& candidate = candidates[indices[k]];
    const ViewPose& pose = candidate.pose;
    const ViewPose small_pose{[&](double row) { return pose.T_map_camera((row + 0.5) * row_scale - 0.5); },
                              pose.rolling};
    parts[k] = PartsOf(intrinsics, candidate, renderer.Render(small_pose));
  });

  std::vector<std::size_t> chosen;
  std::vector<bool> taken(count, false);
  std::map<PlaceKey, int> uses;
  Eigen::MatrixXd information = PriorInformation(intrinsics);
  while (chosen.size() < options.count) {
    double best = LogDeterminant(information);
    std::size_t best_view = count;
    Eigen::MatrixXd best_information;
    for (std::size_t k = 0; k < count; ++k) {
      if (taken[k] || parts[k].empty()) continue;
      Eigen::MatrixXd with = information;
      for (const Part& part : parts[k]) {
        const auto used = uses.find(part.place);
        const double share = 1.0 + (used == uses.end() ? 0 : used->second);
        with += part.information / (share * share);
      }
      const double value = LogDeterminant(with);
      if (value <= best) continue;
      best = value;
      best_view = k;
      best_information = with;
    }
    if (best_view == count) break;
    taken[best_view] = true;
    information = best_information;
    for (const Part& part : parts[best_view]) ++uses[part.place];
    chosen.push_back(indices[best_view]);
  }
  return chosen;
}

}  // namespace mlic
