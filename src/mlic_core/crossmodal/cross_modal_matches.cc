#include "mlic_core/crossmodal/cross_modal_matches.h"

#include "mlic_core/common/error.h"
#include "mlic_core/common/parallel.h"
#include "mlic_core/geometry/so3.h"

namespace mlic {
namespace {

// Bearings of every so many pixels, interpolated between: good to 1e-4 rad, enough to tell steps of depth.
constexpr int kBearingStep = 8;  // from: derivation

// px (of the level matched at) between the map's points at which the variance of a match is twice that of a
// dense map: the rendering then shows blobs of single points in place of the photo's texture. Measured on
// simulated cars: 0.8 of the claimed variance at 1 to 3 px, 1.4 at 5, 2.4 at 8.
constexpr double kCoarseSpacing = 6.0;  // from: measured

// Row by row, NaN where the camera sees nothing; one column and row beyond the image.
std::vector<Eigen::Vector3f> CoarseBearings(const CameraIntrinsics& intrinsics) {
  std::vector<Eigen::Vector3f> out;
  for (int v = 0; v <= intrinsics.height / kBearingStep + 1; ++v) {
    for (int u = 0; u <= intrinsics.width / kBearingStep + 1; ++u) {
      Eigen::Vector3d bearing;
      const bool seen = Unproject(intrinsics, {u * kBearingStep, v * kBearingStep}, &bearing);
      out.push_back(seen ? bearing.cast<float>().eval() : Eigen::Vector3f::Constant(std::nanf("")).eval());
    }
  }
  return out;
}

// How much larger the variance of a match is where the map is coarse. spacing: m, between its points, by the
// size of a pixel of the level matched at.
double Coarseness(const CameraIntrinsics& intrinsics, const Eigen::Vector2d& pixel, double depth,
                  double spacing) {
  Eigen::Vector3d bearing;
  Eigen::Vector2d back;
  CameraPointJacobian J;
  if (!(depth > 0.0) || !Unproject(intrinsics, pixel, &bearing) ||
      !Project(intrinsics, depth * bearing, &back, &J)) {
    return 1.0;
  }
  const double spacings = std::sqrt(0.5) * J.norm() * spacing / kCoarseSpacing;
  return 1.0 + spacings * spacings;
}

}  // namespace

CameraUncertainty UncertaintyOf(double sigma_rotation, double sigma_translation) {
  CameraUncertainty out;
  out.pose.topLeftCorner<3, 3>().setIdentity();
  out.pose.bottomRightCorner<3, 3>().setIdentity();
  out.pose.topLeftCorner<3, 3>() *= sigma_rotation * sigma_rotation;
  out.pose.bottomRightCorner<3, 3>() *= sigma_translation * sigma_translation;
  return out;
}

Eigen::Matrix2d DisplacementCovariance(const CameraIntrinsics& intrinsics, const Eigen::Vector3d& point,
                                       const CameraUncertainty& uncertainty) {
  Eigen::Matrix2d out = uncertainty.displacement * uncertainty.displacement * Eigen::Matrix2d::Identity();
  Eigen::Vector2d pixel;
  CameraPointJacobian J_point;
  CameraParameterJacobian J_parameters;
  if (!Project(intrinsics, point, &pixel, &J_point, &J_parameters)) return out;
  Eigen::Matrix<double, 2, 6> J;
  J.leftCols<3>() = -J_point * Hat(point);
  J.rightCols<3>() = J_point;
  out += J * uncertainty.pose * J.transpose();
  if (uncertainty.intrinsics.size() > 0) {
    Check(uncertainty.intrinsics.rows() == J_parameters.cols(), "DisplacementCovariance: size of intrinsics");
    out += J_parameters * uncertainty.intrinsics * J_parameters.transpose();
  }
  return out;
}

RenderedStructure StructureOf(const RenderedView& view, const CameraIntrinsics& intrinsics,
                              const ViewPose& pose) {
  RenderedStructure out;
  out.intensity = view.intensity;
  out.normals = view.normal;
  out.range = view.depth;
  out.points = cv::Mat::zeros(view.depth.size(), CV_32FC3);
  const RigidTransform fixed = pose.T_map_camera(0.0);
  const std::vector<Eigen::Vector3f> corners = CoarseBearings(intrinsics);
  const int columns = intrinsics.width / kBearingStep + 2;
  ParallelFor(static_cast<std::size_t>(view.depth.rows), [&](std::size_t row) {
    const int v = static_cast<int>(row);
    const RigidTransform T = pose.rolling ? pose.T_map_camera(v) : fixed;
    const Eigen::Matrix3f R = T.rotation.toRotationMatrix().cast<float>();
    const Eigen::Vector3f t = T.translation.cast<float>();
    const float b = static_cast<float>(v % kBearingStep) / kBearingStep;
    const Eigen::Vector3f* upper = &corners[static_cast<std::size_t>(v / kBearingStep * columns)];
    const Eigen::Vector3f* lower = upper + columns;
    for (int u = 0; u < view.depth.cols; ++u) {
      const float depth = view.depth.at<float>(v, u);
      if (!(depth > 0.0f)) continue;
      const float a = static_cast<float>(u % kBearingStep) / kBearingStep;
      const int i = u / kBearingStep;
      const Eigen::Vector3f bearing = (1.0f - b) * ((1.0f - a) * upper[i] + a * upper[i + 1]) +
                                      b * ((1.0f - a) * lower[i] + a * lower[i + 1]);
      const Eigen::Vector3f p = R * (depth * bearing) + t;
      if (p.allFinite()) out.points.at<cv::Vec3f>(v, u) = {p.x(), p.y(), p.z()};
    }
  });
  return out;
}

std::vector<MapMatch> MatchView(const RenderedView& view, const CameraIntrinsics& intrinsics,
                                const ViewPose& pose, const cv::Mat& gray, const cv::Mat& mask,
                                const CameraUncertainty& uncertainty, const CrossModalOptions& options) {
  const StructurePyramid photo = PhotoStructure(gray, mask, options.structure);
  return MatchView(view, intrinsics, pose, photo, uncertainty, options);
}

std::vector<MapMatch> MatchView(const RenderedView& view, const CameraIntrinsics& intrinsics,
                                const ViewPose& pose, const StructurePyramid& photo,
                                const CameraUncertainty& uncertainty, const CrossModalOptions& options) {
  Check(!photo.empty() && view.intensity.cols == photo[0].width && view.intensity.rows == photo[0].height,
        "MatchView: rendering and photo of different sizes");
  const StructurePyramid rendering = MapStructure(StructureOf(view, intrinsics, pose), options.structure);
  const auto predicted = [&](const Eigen::Vector2d& pixel) -> Eigen::Matrix2d {
    const float depth = view.depth.at<float>(static_cast<int>(pixel.y()), static_cast<int>(pixel.x()));
    Eigen::Vector3d bearing = Eigen::Vector3d::UnitZ();
    Unproject(intrinsics, pixel, &bearing);
    return DisplacementCovariance(intrinsics, (depth > 0.0f ? depth : 10.0) * bearing, uncertainty);
  };
  StructureMatchOptions match_options = options.match;
  match_options.finest_level = options.structure.finest_level;
  std::vector<MapMatch> matches;
  for (const StructureMatch& found : MatchStructure(rendering, photo, predicted, match_options)) {
    MapMatch match;
    if (!SurfaceAt(view, intrinsics, pose, found.rendered, &match.point)) continue;
    const int row = static_cast<int>(found.rendered.y()), column = static_cast<int>(found.rendered.x());
    match.map_point = view.point.at<std::int32_t>(row, column);
    match.rendered = found.rendered;
    match.pixel = found.rendered + found.displacement;
    const double spacing = view.spacing.at<float>(row, column) / (1 << match_options.finest_level);
    match.covariance =
        found.covariance * Coarseness(intrinsics, found.rendered, view.depth.at<float>(row, column), spacing);
    match.score = found.score;
    match.peak_ratio = found.peak_ratio;
    if (match.map_point >= 0) matches.push_back(match);
  }
  return matches;
}

}  // namespace mlic
