#include "mlic_core/uncertainty/range_errors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "mlic_core/association/ring_corrections.h"
#include "mlic_core/geometry/symmetric_matrix.h"
#include "mlic_core/problem/joint_solver.h"
#include "mlic_core/problem/landmark_rows.h"
#include "mlic_core/problem/layout.h"
#include "mlic_core/problem/linearizer.h"
#include "mlic_core/problem/plane_terms.h"
#include "mlic_core/problem/priors.h"
#include "mlic_core/problem/time_windows.h"
#include "mlic_core/solver/normal_equations.h"
#include "mlic_core/uncertainty/range_columns.h"
#include "mlic_core/uncertainty/widened_equations.h"

namespace mlic {
namespace {

// Of the priors on all parameters: keep what nothing shows where it is. from: guard, LiDARs err by up to
// 0.03 m
constexpr double kPriorSigma = 0.1;
// Of what planes hide at grazing incidence: for each power of ten of its cosine. from: guard, bumps of ground
// and walls are a centimetre high
constexpr double kHiddenSigma = 0.01;

// A measurement along a beam as the equations have it: its residual by eight control points, its LiDAR's pose
// and offset (laid out as PointToPlane), its clock's drift, and the plane or point that it measures.
template <typename ByMotion>
struct BeamRow {
  std::size_t lidar;
  const KnotColumns& columns;
  const ByMotion& by;
  double by_drift;
  Eigen::Vector3d by_measured;
  double residual;
};

// What a parameter by which the residual grows so much shares with all others that are no errors of ranges.
template <typename Row>
void AddShared(const LinearizationPoint& at, const Row& row, Eigen::Index to, double own,
               LandmarkCoupling* coupling, Accumulator* sum) {
  const auto share = [&](Eigen::Index with, double value) {
    sum->corner(to, with) += value;
    sum->corner(with, to) += value;
  };
  sum->gradient_calibration[to] += own * row.residual;
  const Eigen::Index sensor = Layout::Lidar(row.lidar);
  for (int k = 0; k < Layout::kOfSensor; ++k) share(sensor + k, own * row.by[PointToPlane::kExtrinsic + k]);
  if (const int drift = at.layout.Drift(LidarId(row.lidar)); drift >= 0) share(drift, own * row.by_drift);
  for (int k = 0; k < 8; ++k) {
    sum->border.template block<1, 3>(to, sum->Local(row.columns[k])) +=
        own * row.by.template segment<3>(3 * k).transpose();
  }
  coupling->calibration.row(to) += own * row.by_measured.transpose();
}

// A longer range makes a residual smaller: it is along the beam.
void AddRangesOfPlane(const LinearizationPoint& at, const RangeRow& range_row, std::size_t drive,
                      std::size_t plane, LandmarkCoupling* coupling, Accumulator* sum) {
  const PlaneAssociation& association = at.problem.drives[drive].planes;
  const SplitSpline& trajectory = at.state.drives[drive].trajectory;
  const PlaneRows rows = RowsOfPlane(association, at.state, drive, plane);
  const Eigen::Index reliefs = at.layout.calibration + ColumnOf(at.state.lidars.size(), 0);
  for (Eigen::Index i = 0; i < rows.residuals.size(); ++i) {
    const PlaneObservation& o = association.observations[rows.observations[i]];
    const double t = at.state.lidars[o.lidar].OnImuClock(o.time, trajectory.Middle());
    const RangeRow::Vector own = -rows.units[i] / o.sigma * range_row.Of(o, association.planes[plane].plane);
    const auto by = rows.jacobian.col(i);
    const KnotColumns columns(at.layout, drive, SplineBasis(trajectory.rotation.knots(), t).first,
                              SplineBasis(trajectory.position.knots(), t).first);
    std::array<Eigen::Index, RangeRow::kSize> to;
    for (int k = 0; k < RangeRow::kSize; ++k) {
      to[k] = k < kRangeColumns ? at.layout.calibration + ColumnOf(o.lidar, k) : reliefs + k - kRangeColumns;
    }
    const double by_drift = (o.time - trajectory.Middle()) * by[PointToPlane::kTimeOffset];
    const BeamRow<decltype(by)> row{static_cast<std::size_t>(o.lidar),   columns,          by, by_drift,
                                    by.segment<3>(PointToPlane::kPlane), rows.residuals[i]};
    for (int a = 0; a < RangeRow::kSize; ++a) {
      if (own[a] == 0.0) continue;
      for (int b = 0; b < RangeRow::kSize; ++b) sum->corner(to[a], to[b]) += own[a] * own[b];
      AddShared(at, row, to[a], own[a], coupling, sum);
    }
  }
}

// Of a point of the map that a camera sees: what its LiDAR measured along the beam.
void AddRangesOfLandmark(const LinearizationPoint& at, std::size_t drive, std::size_t point,
                         LandmarkCoupling* coupling, Accumulator* sum) {
  namespace rows_of = landmark_rows;
  const LandmarkSet& set = at.problem.drives[drive].landmarks;
  const LidarPointObservation& o = set.lidar_points[point];
  const rows_of::PointChart chart(set.points[point]);
  double cost = 0.0;  // the observations' own, counted already
  rows_of::WithLidarRows(
      at, drive, point, chart.Jacobian().transpose(), &cost,
      [&](const rows_of::Bases& bases, const rows_of::LidarRows& rows) {
        const auto by = rows.col(2);  // along the beam
        const std::array<std::pair<RangeColumn, double>, 2> own = {
            std::pair(kOneOfSeen, -1.0 / o.sigma_along),
            std::pair(kElevationOfSeen, -ElevationOf(o.position.cast<float>()) / o.sigma_along)};
        const KnotColumns columns(at.layout, drive, bases.rotation.first, bases.position.first);
        const BeamRow<decltype(by)> row{static_cast<std::size_t>(o.lidar),
                                        columns,
                                        by,
                                        by[rows_of::kDrift],
                                        by.segment<3>(rows_of::kPoint),
                                        by[rows_of::kResidual]};
        for (const auto& [column, size] : own) {
          const Eigen::Index to = at.layout.calibration + ColumnOf(o.lidar, column);
          for (const auto& [other, other_size] : own) {
            sum->corner(to, at.layout.calibration + ColumnOf(o.lidar, other)) += size * other_size;
          }
          AddShared(at, row, to, size, coupling, sum);
        }
      });
}

void AddRanges(const LinearizationPoint& at, const RangeRow& row, std::vector<LandmarkCoupling>* couplings,
               Accumulator* sum) {
  Widen(WithReliefs(at.state.lidars.size(), kRangeColumns), sum, couplings);
  LandmarkCoupling* of_drive = couplings->data();
  for (std::size_t d = 0; d < at.problem.drives.size(); ++d) {
    const DriveTerms& drive = at.problem.drives[d];
    for (std::size_t p = 0; p < drive.planes.planes.size(); ++p)
      AddRangesOfPlane(at, row, d, p, of_drive + p, sum);
    for (std::size_t p = 0; p < drive.landmarks.points.size(); ++p) {
      if (!drive.landmarks.IsOnMap(p)) continue;
      AddRangesOfLandmark(at, d, p, of_drive + drive.planes.planes.size() + p, sum);
    }
    of_drive += drive.planes.planes.size() + drive.landmarks.points.size();
  }
}

// Of each LiDAR's slope, m/rad: what the errors of its rings, each for itself, leave of one over their
// elevations, these spread as its points are. Corrections of rings leave it out.
std::vector<double> SlopeSigmas(const JointProblem& problem, const CalibrationState& state) {
  std::vector<Eigen::Array3d> moments(state.lidars.size(), Eigen::Array3d::Zero());  // of elevations
  for (const DriveTerms& drive : problem.drives) {
    for (const PlaneObservation& o : drive.planes.observations) {
      const double elevation = ElevationOf(o.position);
      moments[o.lidar] += Eigen::Array3d(1.0, elevation, elevation * elevation);
    }
  }
  std::vector<double> sigmas(moments.size(), kPriorSigma);
  for (std::size_t l = 0; l < sigmas.size() && l < state.rings.size(); ++l) {
    const RingCorrections& rings = state.rings[l];
    const Eigen::Array3d mean = moments[l] / std::max(1.0, moments[l][0]);
    const double spread = std::sqrt(std::max(1e-12, mean[2] - mean[1] * mean[1]));
    const auto corrected = [](const RingCorrection& ring) { return ring.range != 0.0f; };
    const auto count = std::count_if(rings.begin(), rings.end(), corrected);
    if (count == 0) continue;
    sigmas[l] = TypicalCorrection(rings).range / (spread * std::sqrt(static_cast<double>(count)));
  }
  return sigmas;
}

// These rows and columns of the inverse, zero where not free.
Eigen::MatrixXd PartOfCovariance(Eigen::MatrixXd information, const std::vector<bool>& free,
                                 Eigen::Index begin, Eigen::Index count) {
  const Eigen::Index size = information.rows();
  HoldFixed(free, &information);
  const Eigen::MatrixXd part = Eigen::MatrixXd::Identity(size, size).middleCols(begin, count);
  Eigen::MatrixXd covariance = SolveSymmetric(information, part).middleRows(begin, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    if (!free[begin + i]) covariance(i, i) = 0.0;
  }
  return covariance;
}

}  // namespace

RangeEquations::RangeEquations(const JointProblem& given, const CalibrationState& state)
    : problem_(given), state_(state), references_(UsualIntensities(given, state)) {
  if (given.fix_trajectory) return;
  std::vector<std::vector<std::size_t>> origins;
  const JointProblem problem = WithShortCouplings(given, state, &origins);
  const Layout layout(state, problem.estimate_imu_matrices);
  const LinearizationPoint at{problem, state, layout};
  std::vector<LandmarkCoupling> couplings;
  Accumulator sum = Linearize(at, &couplings);
  AddRanges(at, RangeRow(problem, references_), &couplings, &sum);
  CalibrationPrior(problem, state, layout, &of_calibration_.information, &of_calibration_.gradient);
  AddHeldTranslations(problem, state, &of_calibration_.information, &of_calibration_.gradient);
  free_calibration_ = FreeCalibration(problem, layout);
  // Reduced only: what is solved for hangs on the model.
  const Eigen::Index size = sum.corner.rows();
  const NormalSolution reduced =
      SolveNormalEquations(sum, couplings, Eigen::MatrixXd::Zero(size, size), Eigen::VectorXd::Zero(size),
                           std::vector<bool>(static_cast<std::size_t>(size), false), 0.0, false);
  solved_ = reduced.solved;
  information_ = reduced.information;
  gradient_ = reduced.gradient;
}

std::optional<RangeErrors> RangeEquations::Measure(RangeModel model,
                                                   const std::vector<FreeRanges>& free_ranges) const {
  const auto any = [](const FreeRanges& f) { return std::find(f.begin(), f.end(), true) != f.end(); };
  const auto walks = [](const FreeRanges& f) { return f[kRangeWalk]; };
  if (!solved_ || std::none_of(free_ranges.begin(), free_ranges.end(), any)) return std::nullopt;
  const std::size_t lidars = free_ranges.size();
  const Eigen::Index old = of_calibration_.gradient.size();
  const Eigen::Index more = WithReliefs(lidars, kRangeParameters), count = more - kReliefs;
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(gradient_.size(), old + more);
  columns.topLeftCorner(old, old).setIdentity();
  for (std::size_t l = 0; l < lidars; ++l) {
    columns.block<kRangeColumns, kRangeParameters>(old + ColumnOf(l, 0),
                                                   old + RangeErrors::Of(l, kRangeOffset)) = ColumnsOf(model);
  }
  columns.bottomRightCorner<kReliefs, kReliefs>().setIdentity();
  const Eigen::MatrixXd information = columns.transpose() * information_ * columns;
  const Prior prior = WidePrior(model, lidars);
  std::vector<bool> free = free_calibration_;
  for (const FreeRanges& f : free_ranges) free.insert(free.end(), f.begin(), f.end());
  free.insert(free.end(), kReliefs, std::any_of(free_ranges.begin(), free_ranges.end(), walks));
  const Eigen::VectorXd steps = SolveCalibration(information, columns.transpose() * gradient_,
                                                 prior.information, prior.gradient, free, 0.0);
  if (!steps.allFinite()) return std::nullopt;
  RangeErrors errors;
  for (Eigen::Index i = 0; i < count; i += kRangeParameters) {
    errors.steps.emplace_back(steps.segment<kRangeParameters>(old + i));
  }
  errors.references = references_;
  errors.covariance = PartOfCovariance(information + prior.information, free, old, count);
  errors.coupling = information.block(0, old, old, count);
  return errors;
}

std::optional<RangeErrors> RangeEquations::MeasureOfAll(RangeModel model, const FreeRanges& free) const {
  return Measure(model, std::vector<FreeRanges>(references_.size(), free));
}

RangeEquations::Prior RangeEquations::WidePrior(RangeModel model, std::size_t lidars) const {
  const Eigen::Index old = of_calibration_.gradient.size();
  const Eigen::Index more = WithReliefs(lidars, kRangeParameters);
  Prior prior = of_calibration_;
  prior.information.conservativeResize(old + more, old + more);
  prior.information.bottomRows(more).setZero();
  prior.information.rightCols(more).setZero();
  prior.information.diagonal().tail(more).setConstant(1.0 / (kPriorSigma * kPriorSigma));
  prior.information.diagonal().tail(kReliefs / 2).setConstant(1.0 / (kHiddenSigma * kHiddenSigma));
  prior.gradient.conservativeResize(old + more);
  prior.gradient.tail(more).setZero();
  if (model != RangeModel::kWhole) return prior;
  const std::vector<double> sigmas = SlopeSigmas(problem_, state_);
  for (std::size_t l = 0; l < state_.ranges.size(); ++l) {
    const Eigen::Index slope = old + RangeErrors::Of(l, kRangeSlope);
    prior.information(slope, slope) = 1.0 / (sigmas[l] * sigmas[l]);
    prior.gradient[slope] = state_.ranges[l].slope * prior.information(slope, slope);
  }
  return prior;
}

}  // namespace mlic
