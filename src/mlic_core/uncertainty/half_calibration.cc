#include "mlic_core/uncertainty/half_calibration.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mlic_core/association/group_errors.h"
#include "mlic_core/association/landmark_noise.h"
#include "mlic_core/association/map_matches.h"
#include "mlic_core/association/plane_association.h"
#include "mlic_core/problem/inverse_in_limits.h"
#include "mlic_core/problem/linearizer.h"
#include "mlic_core/problem/noise_information.h"
#include "mlic_core/problem/partial_problem.h"
#include "mlic_core/problem/priors.h"
#include "mlic_core/problem/time_windows.h"
#include "mlic_core/solver/normal_equations.h"
#include "mlic_core/uncertainty/intrinsics_observability.h"
#include "mlic_core/uncertainty/stamp_doubt.h"

namespace mlic {
namespace {

// Of Gauss-Newton from the found state on; by the second one a LiDAR that was turned by 0.3 deg stands still
// to a tenth of a sigma. from: guard
constexpr int kLeastSteps = 2;
// Tracks that are weighed anew take more of them. from: guard, time
constexpr int kMostSteps = 8;
// Sigmas by which a step still moves a half that stands still. from: guard, far below what is compared
constexpr double kStill = 0.3;

// 1/rad^2 and 1/m^2: next to the cut are control points that hardly any measurement of the half touches, and
// rounding would outweigh these. from: guard, 1e-6 of what a segment's IMU samples say, or less
constexpr double kControlPoint = 1.0;

// Fills prior and guesses. What the data of a half do not show at all stays within ten limits of where it is.
void SetPriors(const JointProblem& problem, const CalibrationState& state, const Layout& layout,
               const std::vector<bool>& free_calibration, const Eigen::VectorXd& limits,
               HalfCalibration* half) {
  constexpr double kLoose = 10.0, kFixed = 1e-6;  // limits; from: guard, far beyond what is compared
  Eigen::VectorXd gradient;                       // none: the priors stand about the found state
  CalibrationPrior(problem, state, layout, &half->prior, &gradient);
  AddHeldTranslations(problem, state, &half->prior, &gradient);
  half->guesses = Eigen::MatrixXd::Zero(half->prior.rows(), half->prior.cols());
  half->guesses.topLeftCorner(layout.poses, layout.poses) =
      half->prior.topLeftCorner(layout.poses, layout.poses);
  for (Eigen::Index i = 0; i < limits.size(); ++i) {
    const bool moves = free_calibration[static_cast<std::size_t>(i)];
    half->prior(i, i) += std::pow(limits[i] * (moves ? kLoose : kFixed), -2);
  }
}

// What the stretch saw of the tracks, with the part's times. state: the whole's.
TrackSet TracksWithin(const DriveStretch& stretch, const TrackSet& whole, const CalibrationState& state) {
  TrackSet part;
  part.keyframes = whole.keyframes;
  std::vector<bool> within;
  for (Keyframe& keyframe : part.keyframes) {
    const SensorCalibration& camera = state.cameras[keyframe.camera].sensor;
    within.push_back(stretch.Contains(camera, keyframe.time));
    keyframe.time = stretch.Shifted(camera, keyframe.time);
  }
  for (const Track& track : whole.tracks) {
    Track seen;
    for (const TrackObservation& o : track.observations) {
      if (within[o.keyframe]) seen.observations.push_back(o);
    }
    if (seen.observations.size() > 1) part.tracks.push_back(std::move(seen));
  }
  return part;
}

// The cameras' landmarks of a half, made anew for each step.
class HalfLandmarks {
 public:
  // part: loses its landmarks, which Place puts back.
  HalfLandmarks(const Adjustment& adjustment, PartialProblem* part)
      : options_(adjustment.cameras.landmark_options), tracks_(OnTime(adjustment.cameras)) {
    for (std::size_t d = 0; d < tracks_.size(); ++d) {
      LandmarkSet& landmarks = part->problem.drives[d].landmarks;
      tracks_[d] = TracksWithin(part->stretches[d], tracks_[d], adjustment.state);
      on_map_.push_back(PointsOnMap(landmarks));
      landmarks = {};
    }
  }

  void Place(const CalibrationState& state, JointProblem* problem) {
    if (placed_) options_.noise = MeasureLandmarkNoise(problem->drives, state, options_);
    placed_ = !tracks_.empty();
    for (std::size_t d = 0; d < tracks_.size(); ++d) {
      LandmarkSet landmarks = TriangulateLandmarks(tracks_[d], state, d, options_);
      Append(on_map_[d], &landmarks);
      std::vector<std::size_t> origins;
      problem->drives[d].landmarks = SplitPoints(landmarks, state, d, kLongestPointCoupling, &origins);
    }
  }

  // With which they were made.
  const LandmarkOptions& Options() const { return options_; }

 private:
  LandmarkOptions options_;
  std::vector<TrackSet> tracks_;
  std::vector<LandmarkSet> on_map_;
  bool placed_ = false;
};

// By what the half's information is too good, measured at its own solution: in the whole's residuals what the
// halves disagree on looks like errors that observations share, and would excuse itself; and a share of the
// whole's noise is not the half's.
void MeasureGrowth(const Adjustment& adjustment, const LandmarkOptions& made_with,
                   const JointProblem& problem, const CalibrationState& state,
                   const CancellationToken& cancellation, HalfCalibration* half) {
  half->correlation = CorrelationFactor(problem.drives, state);
  half->stamps = SumStampErrors(problem, state);
  const LinearizedProblem linearized(problem, state);
  if (adjustment.noise_information.rows() == half->information.rows()) {
    half->noise = NoiseInformation(linearized, cancellation);
  }
  if (adjustment.scale.inflation.cameras.IsEmpty()) return;
  const Layout layout(state, problem.estimate_imu_matrices);
  const Eigen::MatrixXd covariance =
      InverseInLimits(half->information + half->prior, CalibrationLimits(state, layout));
  half->cameras = MeasureCameraInflation(linearized, made_with, covariance);
  if (half->cameras.IsEmpty()) half->cameras = adjustment.scale.inflation.cameras;
}

// By how many of its sigmas a step moves the calibration, at most.
double InSigmas(const Eigen::VectorXd& step, const HalfCalibration& half, double scale,
                const Eigen::VectorXd& limits) {
  const Eigen::MatrixXd covariance = InverseInLimits(half.information / scale + half.prior, limits);
  return (step.array().abs() / covariance.diagonal().array().sqrt()).maxCoeff();
}

}  // namespace

Eigen::MatrixXd WithoutFixed(Eigen::MatrixXd matrix, const std::vector<bool>& free_calibration) {
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    if (free_calibration[static_cast<std::size_t>(i)]) continue;
    matrix.row(i).setZero();
    matrix.col(i).setZero();
  }
  return matrix;
}

std::optional<HalfCalibration> CalibrateHalf(const Adjustment& adjustment, double scale,
                                             const std::vector<TimeInterval>& stretches,
                                             const CancellationToken& cancellation) {
  PartialProblem part(adjustment.problem, adjustment.state, stretches);
  HalfLandmarks landmarks(adjustment, &part);
  CalibrationState& state = part.state;
  JointProblem& problem = part.problem;
  const Layout layout(state, problem.estimate_imu_matrices);
  const std::vector<bool> free_calibration = FreeCalibration(problem, layout);
  const Eigen::VectorXd limits = CalibrationLimits(state, layout);
  HalfCalibration half;
  SetPriors(problem, state, layout, free_calibration, limits, &half);
  half.moved = Eigen::VectorXd::Zero(layout.calibration);
  double change = kStill;
  for (int step = 0; step < kMostSteps && (step < kLeastSteps || change >= kStill); ++step) {
    cancellation.ThrowIfCancelled();
    landmarks.Place(state, &problem);
    std::vector<LandmarkCoupling> couplings;
    Accumulator sum = Linearize({problem, state, layout}, &couplings);
    sum.band.row(0).array() += kControlPoint;
    const NormalSolution solution = SolveNormalEquations(
        sum, couplings, scale * half.prior, scale * half.prior * half.moved, free_calibration, 0.0, false);
    if (!solution.solved) return std::nullopt;
    layout.Update(solution.delta, &state);
    MoveLandmarks(LandmarkSteps(couplings, solution.delta), &problem);
    half.moved += solution.delta.tail(layout.calibration);
    half.information = WithoutFixed(solution.information, free_calibration);
    change = InSigmas(solution.delta.tail(layout.calibration), half, scale, limits);
  }
  problem.dataset = adjustment.problem.dataset;  // with the scans
  MeasureGrowth(adjustment, landmarks.Options(), problem, state, cancellation, &half);
  return half;
}

}  // namespace mlic
