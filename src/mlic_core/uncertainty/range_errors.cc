#include "mlic_core/uncertainty/range_errors.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "mlic_core/association/ring_corrections.h"
#include "mlic_core/geometry/symmetric_matrix.h"
#include "mlic_core/problem/joint_solver.h"
#include "mlic_core/problem/layout.h"
#include "mlic_core/problem/linearizer.h"
#include "mlic_core/problem/plane_terms.h"
#include "mlic_core/problem/priors.h"
#include "mlic_core/problem/time_windows.h"
#include "mlic_core/solver/normal_equations.h"

namespace mlic {
namespace {

// Of the priors on offsets (m) and slope (m/rad): keep what nothing shows where it is. from: guard, LiDARs
// err by up to 0.03 m
constexpr double kPriorSigma = 0.1;
// sigmas, which the error itself widens by the correlation that it gives residuals; from: derivation, 3 of
// 1000 normal errors lie beyond
constexpr double kFarFromZero = 3.0;
constexpr double kFlatness = 1e-3;  // m, of what counts as flat; from: guard, walls and their returns
constexpr double kMoves = 0.1;      // of a sigma; from: guard, rounds end where less moves

// Makes room for so many parameters after the calibration's.
void Widen(Eigen::Index more, Accumulator* sum, std::vector<LandmarkCoupling>* couplings) {
  const Eigen::Index old = sum->corner.rows(), wide = old + more;
  const auto widen_rows = [&](auto* matrix) {
    matrix->conservativeResize(wide, matrix->cols());
    matrix->bottomRows(more).setZero();
  };
  widen_rows(&sum->border);
  widen_rows(&sum->gradient_calibration);
  sum->corner.conservativeResize(wide, wide);
  sum->corner.bottomRows(more).setZero();
  sum->corner.rightCols(more).setZero();
  for (LandmarkCoupling& coupling : *couplings) widen_rows(&coupling.calibration);
}

constexpr int kOfLidar = 3;  // from: structural
constexpr int kLevel = 2;    // of these, that of level planes; from: structural
using OfLidar = Eigen::Matrix<double, kOfLidar, 1>;

bool Within45Degrees(double cosine) { return cosine * cosine > 0.5; }

// By what a point's range grows with its LiDAR's parameters.
OfLidar RangeRow(const PlaneObservation& o, const Plane& plane, RangeModel model) {
  const bool level = Within45Degrees(plane.normal.z());
  if (model == RangeModel::kOffsetAndSlope) return {1.0, ElevationOf(o.position), level ? 1.0 : 0.0};
  return OfLidar::Unit(level ? kLevel : Within45Degrees(o.cos_incidence) ? 0 : 1);
}

// Where the first parameter of a LiDAR stands among the widened calibration.
Eigen::Index RangesOf(const Layout& layout, std::size_t lidar) {
  return layout.calibration + kOfLidar * static_cast<Eigen::Index>(lidar);
}

// A longer range makes a residual smaller: it is along the beam.
void AddRangesOfPlane(const LinearizationPoint& at, RangeModel model, std::size_t drive, std::size_t plane,
                      LandmarkCoupling* coupling, Accumulator* sum) {
  const PlaneAssociation& association = at.problem.drives[drive].planes;
  const SplitSpline& trajectory = at.state.drives[drive].trajectory;
  const PlaneRows rows = RowsOfPlane(association, at.state, drive, plane);
  for (Eigen::Index i = 0; i < rows.residuals.size(); ++i) {
    const PlaneObservation& o = association.observations[rows.observations[i]];
    const double t = at.state.lidars[o.lidar].OnImuClock(o.time, trajectory.Middle());
    const OfLidar own = -rows.units[i] / o.sigma * RangeRow(o, association.planes[plane].plane, model);
    const Eigen::Index begin = RangesOf(at.layout, o.lidar);
    const Eigen::Matrix<double, kOfLidar, PointToPlane::kColumns> row =
        own * rows.jacobian.col(i).transpose();
    sum->corner.block<kOfLidar, kOfLidar>(begin, begin) += own * own.transpose();
    sum->gradient_calibration.segment<kOfLidar>(begin) += own * rows.residuals[i];
    const auto with_lidar = row.middleCols<Layout::kOfSensor>(PointToPlane::kExtrinsic);
    sum->corner.block<kOfLidar, Layout::kOfSensor>(begin, Layout::Lidar(o.lidar)) += with_lidar;
    sum->corner.block<Layout::kOfSensor, kOfLidar>(Layout::Lidar(o.lidar), begin) += with_lidar.transpose();
    if (const int drift = at.layout.Drift(LidarId(o.lidar)); drift >= 0) {
      const OfLidar with_drift = (o.time - trajectory.Middle()) * row.col(PointToPlane::kTimeOffset);
      sum->corner.block<kOfLidar, 1>(begin, drift) += with_drift;
      sum->corner.block<1, kOfLidar>(drift, begin) += with_drift.transpose();
    }
    const KnotColumns columns(at.layout, drive, SplineBasis(trajectory.rotation.knots(), t).first,
                              SplineBasis(trajectory.position.knots(), t).first);
    for (int k = 0; k < 8; ++k) {
      sum->border.block<kOfLidar, 3>(begin, sum->Local(columns[k])) += row.middleCols<3>(3 * k);
    }
    coupling->calibration.middleRows<kOfLidar>(begin) += row.middleCols<3>(PointToPlane::kPlane);
  }
}

void AddRanges(const LinearizationPoint& at, RangeModel model, std::vector<LandmarkCoupling>* couplings,
               Accumulator* sum) {
  Widen(kOfLidar * static_cast<Eigen::Index>(at.state.lidars.size()), sum, couplings);
  LandmarkCoupling* of_drive = couplings->data();
  for (std::size_t d = 0; d < at.problem.drives.size(); ++d) {
    const DriveTerms& drive = at.problem.drives[d];
    for (std::size_t p = 0; p < drive.planes.planes.size(); ++p)
      AddRangesOfPlane(at, model, d, p, of_drive + p, sum);
    of_drive += drive.planes.planes.size() + drive.landmarks.points.size();
  }
}

struct Prior {
  Eigen::MatrixXd information;
  Eigen::VectorXd gradient;
};

Prior WidePrior(const LinearizationPoint& at) {
  const Eigen::Index old = at.layout.calibration;
  const Eigen::Index more = kOfLidar * static_cast<Eigen::Index>(at.state.lidars.size());
  Prior prior;
  CalibrationPrior(at.problem, at.state, at.layout, &prior.information, &prior.gradient);
  AddHeldTranslations(at.problem, at.state, &prior.information, &prior.gradient);
  prior.information.conservativeResize(old + more, old + more);
  prior.information.bottomRows(more).setZero();
  prior.information.rightCols(more).setZero();
  prior.information.diagonal().tail(more).setConstant(1.0 / (kPriorSigma * kPriorSigma));
  prior.gradient.conservativeResize(old + more);
  prior.gradient.tail(more).setZero();
  return prior;
}

// The last `count` rows and columns of the inverse, zero where not free.
Eigen::MatrixXd LastOfCovariance(Eigen::MatrixXd information, const std::vector<bool>& free,
                                 Eigen::Index count) {
  const Eigen::Index size = information.rows();
  for (Eigen::Index i = 0; i < size; ++i) {
    if (free[i]) continue;
    information.row(i).setZero();
    information.col(i).setZero();
    information(i, i) = 1.0;
  }
  const Eigen::MatrixXd last = Eigen::MatrixXd::Identity(size, size).rightCols(count);
  Eigen::MatrixXd covariance = SolveSymmetric(information, last).bottomRows(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    if (!free[size - count + i]) covariance(i, i) = 0.0;
  }
  return covariance;
}

OfLidar SigmasOf(const RangeErrors& errors, std::size_t lidar, double correlation) {
  const auto begin = kOfLidar * static_cast<Eigen::Index>(lidar);
  return (correlation * errors.covariance.diagonal().segment<kOfLidar>(begin)).cwiseSqrt();
}

// errors: by surface.
bool IsConfirmed(const RangeErrors& errors, std::size_t lidar, double correlation) {
  const auto begin = kOfLidar * static_cast<Eigen::Index>(lidar);
  const Eigen::Vector2d both = errors.steps[lidar].head<2>();
  if (std::abs(both[0] - both[1]) >= both.cwiseAbs().minCoeff()) return false;
  const Eigen::Matrix2d covariance = correlation * errors.covariance.block<2, 2>(begin, begin);
  const Eigen::Vector2d weights = SolveSymmetric(covariance, Eigen::Vector2d::Ones());
  const double offset = weights.dot(both) / weights.sum();
  return std::abs(offset) > kFarFromZero * std::hypot(std::sqrt(1.0 / weights.sum()), kFlatness);
}

bool IsCorrected(const CalibrationState& state, std::size_t lidar) {
  return lidar < state.ranges.size() && state.ranges[lidar].offset != 0.0;
}

// What is found of a LiDAR whose ranges are corrected.
FreeRanges FreeOfCorrected(const CalibrationState& state, std::size_t lidar) {
  return {true, lidar < state.rings.size() && !state.rings[lidar].empty(), true};
}

std::vector<FreeRanges> FreeOfCorrected(const CalibrationState& state) {
  std::vector<FreeRanges> free(state.lidars.size(), FreeRanges{});
  for (std::size_t l = 0; l < free.size(); ++l) {
    if (IsCorrected(state, l)) free[l] = FreeOfCorrected(state, l);
  }
  return free;
}

}  // namespace

std::optional<RangeErrors> MeasureRangeErrors(const JointProblem& given, const CalibrationState& state,
                                              RangeModel model, const std::vector<FreeRanges>& free_ranges) {
  const auto any = [](const FreeRanges& f) { return f[0] || f[1] || f[2]; };
  if (given.fix_trajectory || std::none_of(free_ranges.begin(), free_ranges.end(), any)) return std::nullopt;
  std::vector<std::vector<std::size_t>> origins;
  const JointProblem problem = WithShortCouplings(given, state, &origins);
  const Layout layout(state, problem.estimate_imu_matrices);
  const LinearizationPoint at{problem, state, layout};
  std::vector<LandmarkCoupling> couplings;
  Accumulator sum = Linearize(at, &couplings);
  AddRanges(at, model, &couplings, &sum);
  const Prior prior = WidePrior(at);
  std::vector<bool> free = FreeCalibration(problem, layout);
  for (const FreeRanges& f : free_ranges) free.insert(free.end(), f.begin(), f.end());
  const NormalSolution solution =
      SolveNormalEquations(sum, couplings, prior.information, prior.gradient, free, 0.0, false);
  if (!solution.solved) return std::nullopt;
  const auto count = static_cast<Eigen::Index>(kOfLidar * free_ranges.size());
  RangeErrors errors;
  const Eigen::VectorXd steps = solution.delta.tail(count);
  for (Eigen::Index i = 0; i < count; i += kOfLidar) errors.steps.emplace_back(steps.segment<kOfLidar>(i));
  errors.covariance = LastOfCovariance(solution.information + prior.information, free, count);
  errors.coupling = solution.information.topRightCorner(layout.calibration, count);
  return errors;
}

bool AnyRangeCorrected(const CalibrationState& state) {
  for (std::size_t l = 0; l < state.lidars.size(); ++l) {
    if (IsCorrected(state, l)) return true;
  }
  return false;
}

bool CorrectRanges(const JointProblem& problem, double correlation, CalibrationState* state) {
  state->ranges.resize(state->lidars.size());
  std::vector<FreeRanges> free = FreeOfCorrected(*state);
  const std::optional<RangeErrors> apart =
      MeasureRangeErrors(problem, *state, RangeModel::kBySurface,
                         std::vector<FreeRanges>(free.size(), FreeRanges{true, true, true}));
  if (!apart) return false;
  for (std::size_t l = 0; l < free.size(); ++l) {
    if (!free[l][0] && IsConfirmed(*apart, l, correlation)) free[l] = FreeOfCorrected(*state, l);
  }
  const std::optional<RangeErrors> found =
      MeasureRangeErrors(problem, *state, RangeModel::kOffsetAndSlope, free);
  if (!found) return false;
  bool moved = false;
  for (std::size_t l = 0; l < free.size(); ++l) {
    const OfLidar sigmas = SigmasOf(*found, l, correlation);
    for (int k = 0; k < 2; ++k) moved |= free[l][k] && std::abs(found->steps[l][k]) > kMoves * sigmas[k];
    state->ranges[l].offset += found->steps[l][0];
    state->ranges[l].slope += found->steps[l][1];
  }
  return moved;
}

Eigen::MatrixXd ScatterOfRanges(const JointProblem& problem, const CalibrationState& state,
                                double correlation) {
  std::vector<FreeRanges> free = FreeOfCorrected(state);
  for (FreeRanges& of_lidar : free) of_lidar[kLevel] = true;
  const std::optional<RangeErrors> found =
      MeasureRangeErrors(problem, state, RangeModel::kOffsetAndSlope, free);
  const Eigen::Index size = Layout(state, problem.estimate_imu_matrices).calibration;
  if (!found) return Eigen::MatrixXd::Zero(size, size);
  Eigen::MatrixXd coupling = found->coupling;
  Eigen::VectorXd of_level = Eigen::VectorXd::Zero(size);  // of the gradient
  for (std::size_t l = 0; l < free.size(); ++l) {
    auto of_lidar = coupling.col(kOfLidar * static_cast<Eigen::Index>(l) + kLevel);
    const double error = found->steps[l][kLevel], sigma = SigmasOf(*found, l, correlation)[kLevel];
    if (std::abs(error) > kFarFromZero * sigma) of_level += error * of_lidar;
    of_lidar.setZero();  // not corrected
  }
  return coupling * found->covariance * coupling.transpose() + of_level * of_level.transpose() / correlation;
}

}  // namespace mlic
