#include "mlic_core/uncertainty/camera_covariance.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <numeric>

#include "mlic_core/association/landmark_noise.h"
#include "mlic_core/common/parallel.h"
#include "mlic_core/problem/landmark_terms.h"
#include "mlic_core/uncertainty/image_pattern.h"

namespace mlic {
namespace {

// from: measured, paper rig and kitti_0005: errors are shared over 1 to 3 s.
constexpr double kStretch = 3.0;           // s
constexpr int kCells = 6;                  // along the longer side of an image
constexpr int kFewestGroups = 4;           // that say something; from: guard
constexpr double kLeastNotFollowed = 0.2;  // of a group's errors; from: guard, division by it

// One way of putting observations together: columns are groups.
struct Grouping {
  Eigen::MatrixXd moves;     // of the calibration, by the residuals of the group
  Eigen::MatrixXd variance;  // of these, for white residuals

  void Resize(Eigen::Index parameters, Eigen::Index groups) {
    moves = variance = Eigen::MatrixXd::Zero(parameters, groups);
  }
  void Add(const Grouping& other) {
    moves += other.moves;
    variance += other.variance;
  }
};

constexpr int kPatterns = 10;  // polynomials of two variables up to the third order; from: definition
using Patterns = Eigen::Matrix<double, kPatterns, 1>;

// Of the place in the image, -1 to 1 along its longer side.
Patterns PatternsAt(const LandmarkObservation& o, const CameraIntrinsics& intrinsics) {
  const double half = 0.5 * std::max(intrinsics.width, intrinsics.height);
  const double x = (o.pixel.x() + 0.5 - 0.5 * intrinsics.width) / half;
  const double y = (o.pixel.y() + 0.5 - 0.5 * intrinsics.height) / half;
  Patterns patterns;
  patterns << 1.0, x, y, x * x, x * y, y * y, x * x * x, x * x * y, x * y * y, y * y * y;
  return patterns;
}

// One camera's sums for smooth patterns of errors.
struct PatternSums {
  Eigen::MatrixXd gradient_of_x, gradient_of_y;  // of the calibration, by each pattern of a pixel
  Eigen::Matrix<double, kPatterns, kPatterns> squares = Eigen::Matrix<double, kPatterns, kPatterns>::Zero();
  double observations = 0.0;

  explicit PatternSums(Eigen::Index parameters)
      : gradient_of_x(Eigen::MatrixXd::Zero(parameters, kPatterns)), gradient_of_y(gradient_of_x) {}
  // by_pixel: the gradient by the observation's error, px.
  void Add(const Eigen::Matrix<double, Eigen::Dynamic, 2>& by_pixel, const Patterns& patterns) {
    gradient_of_x.noalias() += by_pixel.col(0) * patterns.transpose();
    gradient_of_y.noalias() += by_pixel.col(1) * patterns.transpose();
    squares.noalias() += patterns * patterns.transpose();
    observations += 1.0;
  }
  void Add(const PatternSums& other) {
    gradient_of_x += other.gradient_of_x;
    gradient_of_y += other.gradient_of_y;
    squares += other.squares;
    observations += other.observations;
  }
  // Of the gradient, where the errors' root mean square is `size` (px) and no pattern is likelier than
  // others.
  Eigen::MatrixXd Covariance(double size) const {
    if (observations < kPatterns) return Eigen::MatrixXd::Zero(gradient_of_x.rows(), gradient_of_x.rows());
    Eigen::Matrix<double, kPatterns, kPatterns> mean = squares / observations;
    mean.diagonal().array() += 1e-9;  // an image of which only a corner is seen
    const auto inverse = mean.inverse().eval();
    return size * size / (2.0 * kPatterns) *
           (gradient_of_x * inverse * gradient_of_x.transpose() +
            gradient_of_y * inverse * gradient_of_y.transpose());
  }
};

// Sums over landmarks.
struct Sums {
  Eigen::MatrixXd information, self_weighing;
  Eigen::VectorXd of_observations, of_landmarks;  // squared moves of the calibration by each alone
  Grouping stretches, later_stretches, cells;
  std::vector<PatternSums> patterns;   // of each camera
  std::vector<ImagePattern> in_cells;  // of each camera

  Sums(Eigen::Index parameters, Eigen::Index stretch_count, Eigen::Index cell_count, std::size_t cameras)
      : information(Eigen::MatrixXd::Zero(parameters, parameters)),
        self_weighing(information),
        of_observations(Eigen::VectorXd::Zero(parameters)),
        of_landmarks(of_observations),
        patterns(cameras, PatternSums(parameters)),
        in_cells(cameras, ImagePattern(kCells * kCells)) {
    stretches.Resize(parameters, stretch_count);
    later_stretches.Resize(parameters, stretch_count);
    cells.Resize(parameters, cell_count);
  }
  void Add(const Sums& other) {
    information += other.information;
    self_weighing += other.self_weighing;
    of_observations += other.of_observations;
    of_landmarks += other.of_landmarks;
    stretches.Add(other.stretches);
    later_stretches.Add(other.later_stretches);
    cells.Add(other.cells);
    for (std::size_t c = 0; c < patterns.size(); ++c) patterns[c].Add(other.patterns[c]);
    for (std::size_t c = 0; c < in_cells.size(); ++c) in_cells[c].Add(other.in_cells[c]);
  }
};

struct Groups {
  std::vector<Eigen::Index> first_stretch;  // of each drive, and the end
  std::vector<double> start;                // of each drive
  Eigen::Index cells = 0;

  explicit Groups(const CalibrationState& state) : cells(kCells * kCells * state.cameras.size()) {
    first_stretch.push_back(0);
    for (const DriveState& drive : state.drives) {
      start.push_back(drive.trajectory.Start());
      const double span = drive.trajectory.End() - drive.trajectory.Start();
      first_stretch.push_back(first_stretch.back() + static_cast<Eigen::Index>(span / kStretch) + 2);
    }
  }
  // later: half a stretch.
  Eigen::Index Stretch(std::size_t drive, double time, double later) const {
    return first_stretch[drive] + static_cast<Eigen::Index>((time - start[drive]) / kStretch + later);
  }
  static Eigen::Index Cell(const LandmarkObservation& o, const CameraIntrinsics& intrinsics) {
    const double size = static_cast<double>(std::max(intrinsics.width, intrinsics.height)) / kCells;
    const auto place = [&](double at) { return std::clamp(static_cast<int>(at / size), 0, kCells - 1); };
    return kCells * (kCells * o.camera + place(o.pixel.y())) + place(o.pixel.x());
  }
};

// The rows of a landmark's observations with control points and the point itself left free: two columns for
// each observation.
Eigen::MatrixXd ReducedRows(const std::vector<ReprojectionRows>& observations,
                            const Eigen::MatrixXd& knot_response) {
  const int knots = static_cast<int>(knot_response.cols());
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(knot_response.rows(), 2 * observations.size());
  Eigen::MatrixXd by_point(3, rows.cols());
  for (std::size_t k = 0; k < observations.size(); ++k) {
    auto own = rows.middleCols<2>(2 * k);
    for (std::size_t i = 0; i < observations[k].columns.size(); ++i) {
      const int column = observations[k].columns[i];
      if (column >= knots) {
        own.row(column - knots) += observations[k].jacobian.row(i);
      } else {
        own.noalias() -= knot_response.col(column) * observations[k].jacobian.row(i);
      }
    }
    by_point.middleCols<2>(2 * k) = observations[k].by_point;
  }
  Eigen::Matrix3d point = by_point * by_point.transpose();
  point.diagonal().array() += 1e-9;
  const Eigen::MatrixXd followed = (rows * by_point.transpose()) * point.inverse();
  rows.noalias() -= followed * by_point;
  return rows;
}

// Of one landmark's observations in one cell.
struct CellSums {
  Eigen::Vector2d errors = Eigen::Vector2d::Zero();  // px, by their weights
  double weight = 0.0;                               // 1 / px^2
};

// What all landmarks are put together with.
struct Ground {
  const LinearizationPoint& at;
  const Eigen::MatrixXd& knot_response;
  const Eigen::MatrixXd& covariance;
  const LandmarkOptions& made_with;
  Groups groups;
};

// parts: of the split landmarks, those that are one.
void AddLandmark(const Ground& ground, std::size_t drive, const std::vector<std::size_t>& parts, Sums* sums) {
  const Eigen::Index parameters = ground.covariance.rows();
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(parameters), move = gradient;
  double dependence = 0.0;
  std::size_t count = 0;
  std::map<Eigen::Index, CellSums> in_cells;
  for (const std::size_t part : parts) {
    const std::vector<ReprojectionRows> observations = RowsOfLandmark(ground.at, drive, part);
    if (observations.size() < 2) continue;
    const Eigen::MatrixXd rows = ReducedRows(observations, ground.knot_response);
    const Eigen::MatrixXd influence = ground.covariance * rows;
    sums->information.noalias() += rows * rows.transpose();
    count += observations.size();
    for (std::size_t k = 0; k < observations.size(); ++k) {
      const ReprojectionRows& observation = observations[k];
      const int camera = observation.observation->camera;
      const Eigen::VectorXd of_observation = influence.middleCols<2>(2 * k) * observation.residual;
      const Eigen::VectorXd variance = influence.middleCols<2>(2 * k).rowwise().squaredNorm();
      const auto add = [&](Eigen::Index group, Grouping* grouping) {
        grouping->moves.col(group) += of_observation;
        grouping->variance.col(group) += variance;
      };
      add(ground.groups.Stretch(drive, observation.time, 0.0), &sums->stretches);
      add(ground.groups.Stretch(drive, observation.time, 0.5), &sums->later_stretches);
      const CameraIntrinsics& intrinsics = ground.at.state.cameras[camera].intrinsics;
      const LandmarkObservation& given = *observation.observation;
      const Eigen::Index cell = Groups::Cell(given, intrinsics);
      add(cell, &sums->cells);
      const Eigen::Matrix2d whitening = given.shape.cast<double>() / given.sigma;
      sums->patterns[static_cast<std::size_t>(camera)].Add(rows.middleCols<2>(2 * k) * whitening,
                                                           PatternsAt(given, intrinsics));
      const double weight = 0.5 * whitening.squaredNorm();
      in_cells[cell].errors += weight * (whitening.inverse() * observation.residual);
      in_cells[cell].weight += weight;
      sums->of_observations += of_observation.cwiseAbs2();
      move += of_observation;
      gradient.noalias() += rows.middleCols<2>(2 * k) * observation.residual;
      dependence += std::pow(ground.made_with.noise[camera].dependence, 2);
    }
  }
  if (count == 0) return;
  for (const auto& [cell, own] : in_cells) {
    const auto camera = static_cast<std::size_t>(cell / (kCells * kCells));
    sums->in_cells[camera].Add(static_cast<std::size_t>(cell % (kCells * kCells)), own.errors, own.weight);
  }
  sums->of_landmarks += move.cwiseAbs2();
  if (!ground.made_with.noise_of_each) return;
  // Observations that count for less, by their dependence or for being many, have smaller gradients by as
  // much.
  const double less = dependence / static_cast<double>(count) * std::pow(ManyObservationsScale(count), 2);
  const double curve = 2.0 * less / (kPriorFreedom + LandmarkFreedom(count));
  sums->self_weighing.noalias() += curve * gradient * gradient.transpose();
}

// The variance of each parameter by the scatter of groups; that of single observations where they are too
// few.
Eigen::VectorXd ScatterOfGroups(const Grouping& grouping, const Eigen::MatrixXd& covariance,
                                const Eigen::VectorXd& of_observations) {
  Eigen::VectorXd result = of_observations;
  for (Eigen::Index i = 0; i < result.size(); ++i) {
    std::vector<double> moves;
    for (Eigen::Index g = 0; g < grouping.moves.cols(); ++g) {
      if (!(grouping.variance(i, g) > 0.0)) continue;
      const double followed = grouping.variance(i, g) / covariance(i, i);
      moves.push_back(grouping.moves(i, g) / std::sqrt(std::max(kLeastNotFollowed, 1.0 - followed)));
    }
    if (moves.size() < kFewestGroups) continue;
    const double count = static_cast<double>(moves.size());
    const double mean = std::accumulate(moves.begin(), moves.end(), 0.0) / count;
    double squares = 0.0;
    for (const double move : moves) squares += (move - mean) * (move - mean);
    result[i] = squares * count / (count - 1.0);
  }
  return result;
}

// The places of each camera's rotation, translation, time offset, drift, readout and lens that move.
std::vector<std::vector<int>> Parts(const JointProblem& problem, const CalibrationState& state,
                                    const Layout& layout) {
  std::vector<std::vector<int>> parts;
  for (std::size_t c = 0; c < state.cameras.size(); ++c) {
    const int pose = layout.Camera(c);
    parts.push_back({pose, pose + 1, pose + 2});
    parts.push_back({pose + 3, pose + 4, pose + 5});
    parts.push_back({pose + 6});
    if (layout.Drift(CameraId(c)) >= 0) parts.push_back({layout.Drift(CameraId(c))});
    if (layout.Readout(c) >= 0) parts.push_back({layout.Readout(c)});
    parts.emplace_back();
    for (std::size_t i = 0; i < state.cameras[c].intrinsics.parameters.size(); ++i) {
      const std::vector<bool>& held = problem.cameras[c].fixed.intrinsics;
      if (i >= held.size() || !held[i]) parts.back().push_back(layout.Intrinsics(c) + static_cast<int>(i));
    }
  }
  return parts;
}

}  // namespace

CameraInflation MeasureCameraInflation(const LinearizedProblem& linearized, const LandmarkOptions& made_with,
                                       const Eigen::MatrixXd& covariance) {
  const LinearizationPoint at = linearized.At();
  const Layout& layout = at.layout;
  std::vector<std::vector<std::vector<std::size_t>>> parts(at.problem.drives.size());
  std::size_t count = 0;
  for (std::size_t d = 0; d < linearized.origins.size(); ++d) {
    parts[d].resize(linearized.whole_points[d]);
    for (std::size_t p = 0; p < linearized.origins[d].size(); ++p) {
      if (at.problem.drives[d].landmarks.IsOnMap(p)) continue;
      parts[d][linearized.origins[d][p]].push_back(p);
      ++count;
    }
  }
  if (count == 0 || !linearized.solved) return {};
  const Ground ground{at, linearized.knot_response, covariance, made_with, Groups(at.state)};
  std::vector<Sums> sums(kLinearizationChunks, Sums(layout.calibration, ground.groups.first_stretch.back(),
                                                    ground.groups.cells, at.state.cameras.size()));
  for (std::size_t d = 0; d < parts.size(); ++d) {
    ParallelChunks(parts[d].size(), sums.size(), [&](std::size_t chunk, std::size_t begin, std::size_t end) {
      for (std::size_t p = begin; p < end; ++p) AddLandmark(ground, d, parts[d][p], &sums[chunk]);
    });
  }
  for (std::size_t c = 1; c < sums.size(); ++c) sums[0].Add(sums[c]);
  const Sums& all = sums[0];
  const Eigen::VectorXd claimed = (covariance * all.information * covariance).diagonal();
  const auto beyond = [&](const Grouping& grouping) -> Eigen::VectorXd {
    return ScatterOfGroups(grouping, covariance, all.of_observations) - all.of_observations;
  };
  const Eigen::VectorXd of_stretches = 0.5 * (beyond(all.stretches) + beyond(all.later_stretches));
  const Eigen::VectorXd of_cells = beyond(all.cells);
  CameraInflation inflation{all.information,
                            all.self_weighing,
                            Eigen::VectorXd::Ones(layout.calibration),
                            Eigen::MatrixXd::Zero(layout.calibration, layout.calibration),
                            {}};
  for (std::size_t c = 0; c < all.patterns.size(); ++c) {
    inflation.pattern_errors.push_back(all.in_cells[c].Rms());
    inflation.pattern += all.patterns[c].Covariance(inflation.pattern_errors.back());
  }
  for (const std::vector<int>& part : Parts(at.problem, at.state, layout)) {
    double landmarks = 0.0, stretches = 0.0, cells = 0.0;
    for (const int i : part) {
      if (!(claimed[i] > 0.0)) continue;
      const double share = 1.0 / (claimed[i] * static_cast<double>(part.size()));
      landmarks += share * all.of_landmarks[i];
      stretches += share * of_stretches[i];
      cells += share * of_cells[i];
    }
    const double ratio = landmarks + std::max(0.0, stretches) + std::max(0.0, cells);
    for (const int i : part) inflation.growth[i] = std::sqrt(std::max(1.0, ratio));
  }
  return inflation;
}

Eigen::MatrixXd VarianceOfInflation(const Eigen::MatrixXd& covariance, const CameraInflation& inflation,
                                    double scale) {
  if (inflation.IsEmpty()) return Eigen::MatrixXd::Zero(covariance.rows(), covariance.cols());
  // (H - B)^-1 H (H - B)^-1 - H^-1 up to the second order in B: never negative, whatever B is.
  const Eigen::MatrixXd once = covariance * inflation.self_weighing / scale * covariance;
  const Eigen::MatrixXd twice = once * inflation.self_weighing / scale * covariance;
  const Eigen::MatrixXd of_tracks = covariance * inflation.information / scale * covariance;
  const Eigen::MatrixXd grown = inflation.growth.asDiagonal() * of_tracks * inflation.growth.asDiagonal();
  const Eigen::MatrixXd of_pattern = covariance * inflation.pattern / (scale * scale) * covariance;
  const Eigen::MatrixXd variance = 2.0 * once + 3.0 * twice + (grown - of_tracks) + of_pattern;
  return 0.5 * (variance + variance.transpose());
}

std::vector<std::string> DescribeInflation(const CameraInflation& inflation, const Rig& rig,
                                           const CalibrationState& state) {
  std::vector<std::string> lines;
  if (inflation.IsEmpty()) return lines;
  const Layout layout(state, false);  // cameras come before the matrices
  for (std::size_t c = 0; c < state.cameras.size(); ++c) {
    const int pose = layout.Camera(c), lens = layout.Intrinsics(c);
    const int count = static_cast<int>(state.cameras[c].intrinsics.parameters.size());
    char text[240];
    std::snprintf(
        text, sizeof(text),
        ": observations share errors: their part in the sigmas of rotation, translation, offset and lens "
        "grows by a factor of %.2f, %.2f, %.2f, %.2f",
        inflation.growth[pose], inflation.growth[pose + 3], inflation.growth[pose + 6],
        inflation.growth.segment(lens, count).maxCoeff());
    std::string line = rig.cameras[c].name + text;
    if (layout.Readout(c) >= 0) {
      std::snprintf(text, sizeof(text), ", of the readout by %.2f", inflation.growth[layout.Readout(c)]);
      line += text;
    }
    std::snprintf(text, sizeof(text), "; parts of its image err by %.4f px", inflation.pattern_errors[c]);
    line += text;
    lines.push_back(line);
  }
  return lines;
}

}  // namespace mlic
