#include "mlic_core/uncertainty/camera_covariance.h"

#include <Eigen/LU>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <numeric>

#include "mlic_core/association/landmark_noise.h"
#include "mlic_core/common/parallel.h"
#include "mlic_core/problem/landmark_terms.h"
#include "mlic_core/uncertainty/image_pattern.h"
#include "mlic_core/uncertainty/observation_groups.h"
#include "mlic_core/uncertainty/pair_jacobian.h"

namespace mlic {
namespace {

constexpr int kCellsOfImage = ImageGroups::kCells * ImageGroups::kCells;  // from: structural
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
  Eigen::VectorXd of_observations, of_landmarks;  // squared moves of the quantities by each alone
  ObservationGroups stretches, later_stretches, cells;
  std::vector<PatternSums> patterns;   // of each camera
  std::vector<ImagePattern> in_cells;  // of each camera

  Sums(Eigen::Index parameters, Eigen::Index quantities, Eigen::Index stretch_count, Eigen::Index cell_count,
       std::size_t cameras)
      : information(Eigen::MatrixXd::Zero(parameters, parameters)),
        self_weighing(information),
        of_observations(Eigen::VectorXd::Zero(quantities)),
        of_landmarks(of_observations),
        patterns(cameras, PatternSums(parameters)),
        in_cells(cameras, ImagePattern(kCellsOfImage)) {
    stretches.Resize(quantities, stretch_count);
    later_stretches.Resize(quantities, stretch_count);
    cells.Resize(quantities, cell_count);
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
  const Eigen::SparseMatrix<double, Eigen::RowMajor>& quantities;  // made of the calibration
  const LandmarkOptions& made_with;
  ImageGroups groups;
};

// parts: of the split landmarks, those that are one.
void AddLandmark(const Ground& ground, std::size_t drive, const std::vector<std::size_t>& parts, Sums* sums) {
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(ground.quantities.cols());
  Eigen::VectorXd move = Eigen::VectorXd::Zero(ground.quantities.rows());
  double dependence = 0.0;
  std::size_t count = 0;
  std::map<Eigen::Index, CellSums> in_cells;
  for (const std::size_t part : parts) {
    const std::vector<ReprojectionRows> observations = RowsOfLandmark(ground.at, drive, part);
    if (observations.size() < 2) continue;
    const Eigen::MatrixXd rows = ReducedRows(observations, ground.knot_response);
    const Eigen::MatrixXd influence = ground.quantities * (ground.covariance * rows);
    sums->information.noalias() += rows * rows.transpose();
    count += observations.size();
    for (std::size_t k = 0; k < observations.size(); ++k) {
      const ReprojectionRows& observation = observations[k];
      const int camera = observation.observation->camera;
      const Eigen::VectorXd of_observation = influence.middleCols<2>(2 * k) * observation.residual;
      const Eigen::VectorXd variance = influence.middleCols<2>(2 * k).rowwise().squaredNorm();
      const Eigen::Index stretch = ground.groups.Stretch(drive, observation.time, 0.0);
      const Eigen::Index later = ground.groups.Stretch(drive, observation.time, 0.5);
      sums->stretches.Add(stretch, of_observation, variance);
      sums->later_stretches.Add(later, of_observation, variance);
      const CameraIntrinsics& intrinsics = ground.at.state.cameras[camera].intrinsics;
      const LandmarkObservation& given = *observation.observation;
      const Eigen::Index cell = ImageGroups::Cell(given, intrinsics);
      sums->cells.Add(cell, of_observation, variance);
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
    const auto camera = static_cast<std::size_t>(cell / kCellsOfImage);
    sums->in_cells[camera].Add(static_cast<std::size_t>(cell % kCellsOfImage), own.errors, own.weight);
  }
  sums->of_landmarks += move.cwiseAbs2();
  if (!ground.made_with.noise_of_each) return;
  // Observations that count for less, by their dependence or for being many, have smaller gradients by as
  // much.
  const double less = dependence / static_cast<double>(count) * std::pow(ManyObservationsScale(count), 2);
  const double curve = 2.0 * less / (kPriorFreedom + LandmarkFreedom(count));
  sums->self_weighing.noalias() += curve * gradient * gradient.transpose();
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

// Of each camera to each other sensor: rotation, translation and time offset.
std::vector<CameraInflation::Relation> Relations(const CalibrationState& state, const Layout& layout) {
  const SensorOrder order = state.Sensors();
  std::vector<CameraInflation::Relation> relations;
  for (std::size_t b = state.lidars.size(); b < order.size(); ++b) {
    for (std::size_t a = 0; a < b; ++a) {
      const Eigen::Matrix<double, 7, 14> by_both =
          PairJacobian(state.Sensor(order.At(a)), state.Sensor(order.At(b)));
      Eigen::MatrixXd by_all = Eigen::MatrixXd::Zero(7, layout.calibration);
      by_all.middleCols<7>(Layout::Sensor(a)) = by_both.leftCols<7>();
      by_all.middleCols<7>(Layout::Sensor(b)) = by_both.rightCols<7>();
      for (const auto& [at, count] : {std::pair{0, 3}, std::pair{3, 3}, std::pair{6, 1}}) {
        relations.push_back({by_all.middleRows(at, count), 1.0});
      }
    }
  }
  return relations;
}

// The parameters themselves, and the relations.
Eigen::SparseMatrix<double, Eigen::RowMajor> Quantities(
    Eigen::Index parameters, const std::vector<CameraInflation::Relation>& relations) {
  Eigen::Index rows = parameters;
  for (const auto& relation : relations) rows += relation.directions.rows();
  Eigen::MatrixXd quantities(rows, parameters);
  quantities.topRows(parameters).setIdentity();
  Eigen::Index at = parameters;
  for (const auto& relation : relations) {
    quantities.middleRows(at, relation.directions.rows()) = relation.directions;
    at += relation.directions.rows();
  }
  return quantities.sparseView();
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
  std::vector<CameraInflation::Relation> relations = Relations(at.state, layout);
  const Eigen::SparseMatrix<double, Eigen::RowMajor> quantities = Quantities(layout.calibration, relations);
  const Ground ground{at, linearized.knot_response, covariance, quantities, made_with, ImageGroups(at.state)};
  std::vector<Sums> sums(kLinearizationChunks,
                         Sums(layout.calibration, quantities.rows(), ground.groups.Stretches(),
                              ground.groups.Cells(), at.state.cameras.size()));
  for (std::size_t d = 0; d < parts.size(); ++d) {
    ParallelChunks(parts[d].size(), sums.size(), [&](std::size_t chunk, std::size_t begin, std::size_t end) {
      for (std::size_t p = begin; p < end; ++p) AddLandmark(ground, d, parts[d][p], &sums[chunk]);
    });
  }
  for (std::size_t c = 1; c < sums.size(); ++c) sums[0].Add(sums[c]);
  const Sums& all = sums[0];
  const auto variances_of = [&](const Eigen::MatrixXd& of_calibration) -> Eigen::VectorXd {
    return (quantities * of_calibration).cwiseProduct(Eigen::MatrixXd(quantities)).rowwise().sum();
  };
  const Eigen::VectorXd claimed = variances_of(covariance * all.information * covariance);
  const Eigen::VectorXd variances = variances_of(covariance);
  const auto beyond = [&](const ObservationGroups& groups) -> Eigen::VectorXd {
    return ScatterOfGroups(groups, variances, all.of_observations) - all.of_observations;
  };
  const Eigen::VectorXd of_stretches = 0.5 * (beyond(all.stretches) + beyond(all.later_stretches));
  const Eigen::VectorXd of_cells = beyond(all.cells);
  CameraInflation inflation{all.information,
                            all.self_weighing,
                            Eigen::VectorXd::Ones(layout.calibration),
                            {},
                            Eigen::MatrixXd::Zero(layout.calibration, layout.calibration),
                            {}};
  for (std::size_t c = 0; c < all.patterns.size(); ++c) {
    inflation.pattern_errors.push_back(all.in_cells[c].Rms());
    inflation.pattern += all.patterns[c].Covariance(inflation.pattern_errors.back());
  }
  // Of the variance of these quantities, as far as it is tracks'.
  const auto ratio_of = [&](const std::vector<int>& part) {
    double landmarks = 0.0, stretches = 0.0, cells = 0.0;
    for (const int i : part) {
      if (!(claimed[i] > 0.0)) continue;
      const double share = 1.0 / (claimed[i] * static_cast<double>(part.size()));
      landmarks += share * all.of_landmarks[i];
      stretches += share * of_stretches[i];
      cells += share * of_cells[i];
    }
    return std::max(1.0, landmarks + std::max(0.0, stretches) + std::max(0.0, cells));
  };
  for (const std::vector<int>& part : Parts(at.problem, at.state, layout)) {
    const double growth = std::sqrt(ratio_of(part));
    for (const int i : part) inflation.growth[i] = growth;
  }
  int first = layout.calibration;
  for (CameraInflation::Relation& relation : relations) {
    std::vector<int> part(static_cast<std::size_t>(relation.directions.rows()));
    std::iota(part.begin(), part.end(), first);
    first += static_cast<int>(part.size());
    relation.growth = std::sqrt(ratio_of(part));
  }
  inflation.relations = std::move(relations);
  return inflation;
}

Eigen::MatrixXd VarianceOfInflation(const Eigen::MatrixXd& covariance, const CameraInflation& inflation,
                                    double scale) {
  if (inflation.IsEmpty()) return Eigen::MatrixXd::Zero(covariance.rows(), covariance.cols());
  // (H - B)^-1 H (H - B)^-1 - H^-1 up to the second order in B: never negative, whatever B is.
  const Eigen::MatrixXd once = covariance * inflation.self_weighing / scale * covariance;
  const Eigen::MatrixXd twice = once * inflation.self_weighing / scale * covariance;
  const Eigen::MatrixXd of_tracks = covariance * inflation.information / scale * covariance;
  Eigen::MatrixXd grown = inflation.growth.asDiagonal() * of_tracks * inflation.growth.asDiagonal();
  for (const CameraInflation::Relation& relation : inflation.relations) {
    for (Eigen::Index i = 0; i < relation.directions.rows(); ++i) {
      const Eigen::VectorXd direction = relation.directions.row(i);
      const Eigen::VectorXd coupling = of_tracks * direction;
      const double claimed = direction.dot(coupling);
      if (!(claimed > 0.0)) continue;
      const double missing = relation.growth * relation.growth * claimed - direction.dot(grown * direction);
      if (missing > 0.0) grown += missing / (claimed * claimed) * coupling * coupling.transpose();
    }
  }
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
