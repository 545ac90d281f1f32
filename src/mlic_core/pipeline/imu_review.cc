#include "mlic_core/pipeline/imu_review.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <utility>
#include <vector>

#include "mlic_core/problem/imu_terms.h"
#include "mlic_core/sensors/imu_matrices.h"
#include "mlic_core/uncertainty/bias_wander.h"
#include "mlic_core/uncertainty/imu_alignment.h"
#include "mlic_core/uncertainty/imu_matrices.h"

namespace mlic {
namespace {

// Of each drive whose biases are constant, the equations with a course of them that may wander in their
// place, its steps kUnknownSteps: stays(drive, equations) says whether the course does.
template <typename Stays>
void TryCourses(Adjustment* adjustment, const Stays& stays) {
  for (std::size_t d = 0; d < adjustment->state.drives.size(); ++d) {
    DriveState& drive = adjustment->state.drives[d];
    if (!drive.bias.IsConstant()) continue;
    const std::optional<BiasCourse> course =
        CourseOf(drive.bias, drive.trajectory.Start(), drive.trajectory.End());
    if (!course) continue;
    const BiasCourse constant = std::exchange(drive.bias, *course);
    adjustment->problem.drives[d].bias_steps = kUnknownSteps;
    if (!stays(d, EquationsOfCalibration(adjustment->problem, adjustment->state))) drive.bias = constant;
  }
}

}  // namespace

void MeasureImuSigmas(const Dataset& dataset, Adjustment* adjustment) {
  for (std::size_t d = 0; d < dataset.drives.size(); ++d) {
    adjustment->problem.drives[d].imu_sigma =
        MeasureImuSigma(EvaluateImuResiduals(dataset, adjustment->state, d),
                        adjustment->state.drives[d].trajectory, adjustment->given_imu_sigma[d]);
  }
}

bool ReviewAxes(const AdjustmentContext& context, Adjustment* adjustment) {
  constexpr double kSame = 0.1;  // of projectors; from: guard, rounding and what a round moves
  const double prior_sigma = context.rig.imu.alignment_sigma;
  if (prior_sigma == 0.0) return false;
  AlignmentReview review = ReviewAlignment(adjustment->problem, adjustment->state,
                                           ScaledInformation(*adjustment, context.dataset), prior_sigma);
  // The poses of sensors that are given are to the axes as they are.
  const auto is_given = [](const auto& sensor) { return sensor.fixed; };
  const bool any_given = std::any_of(context.rig.lidars.begin(), context.rig.lidars.end(), is_given) ||
                         std::any_of(context.rig.cameras.begin(), context.rig.cameras.end(), is_given);
  if (any_given || context.rig.imu.accelerometer_axes) {
    review.accelerometer_axes =
        ProjectorOn(context.rig.imu.accelerometer_axes.value_or(std::vector<Eigen::Vector3d>()));
  }
  adjustment->alignment_covariance = review.covariance;
  ImuFreedom& imu = adjustment->problem.imu;
  const auto same = [](const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) { return (a - b).norm() < kSame; };
  const bool same_axes = same(review.accelerometer_axes, adjustment->state.accelerometer_axes);
  if (same(review.shown, imu.alignment_shown) && same_axes) return false;
  imu.alignment_shown = review.shown;
  if (!same_axes) {
    SetAccelerometerAxes(review.accelerometer_axes, &adjustment->state);
    adjustment->rounds.noise_measured = false;
  }
  return true;
}

bool ReviewMatrices(const AdjustmentContext& context, Adjustment* adjustment) {
  JointProblem& problem = adjustment->problem;
  if (adjustment->rounds.matrices_judged || problem.estimate_imu_matrices) return false;
  MatrixEvidence evidence =
      EvidenceOfMatrices(problem, adjustment->state, adjustment->last_solve.imu_matrices,
                         VarianceScale(*adjustment, context.dataset));
  if (!evidence.IsShown()) return false;
  adjustment->rounds.matrices_judged = true;
  CovarianceScale scale;
  MeasureCorrelation(*adjustment, &scale);
  const double growth = scale.correlation / adjustment->scale.correlation;
  evidence = EvidenceOfMatrices(problem, adjustment->state, adjustment->last_solve.imu_matrices,
                                growth * VarianceScale(*adjustment, context.dataset));
  if (!evidence.IsShown()) return false;
  problem.estimate_imu_matrices = true;
  problem.imu.matrix_sigma = evidence.sigma;
  adjustment->rounds.noise_measured = false;
  char text[160];
  std::snprintf(text, sizeof(text),
                "the IMU's scale and axes are off by some %.2f %% (%.0f sigmas): they are estimated",
                100.0 * evidence.sigma, std::sqrt(evidence.gain));
  context.monitor.line(text);
  adjustment->last_solve = SolveAdjustment(context.monitor.cancellation, adjustment);
  return true;
}

bool ReviewBiases(const AdjustmentContext& context, Adjustment* adjustment) {
  if (adjustment->rounds.biases_judged) return false;
  adjustment->rounds.biases_judged = true;
  bool any = false;
  TryCourses(adjustment, [&](std::size_t d, const CalibrationEquations& equations) {
    const BiasEvidence evidence = EvidenceOfWander(adjustment->problem, adjustment->state, equations, d,
                                                   VarianceScale(*adjustment, context.dataset));
    if (evidence.IsShown()) adjustment->problem.drives[d].bias_steps = evidence.steps;
    any |= evidence.IsShown();
    return evidence.IsShown();
  });
  if (!any) return false;
  adjustment->rounds.noise_measured = false;
  adjustment->last_solve = SolveAdjustment(context.monitor.cancellation, adjustment);
  for (const DriveState& drive : adjustment->state.drives) {
    if (drive.bias.IsConstant()) continue;
    const Eigen::Vector2d range = drive.bias.Range();
    char text[200];
    std::snprintf(text, sizeof(text),
                  "the IMU's biases wander by %.1g rad/s and %.1g m/s^2: they are estimated every %.0f s",
                  range[0], range[1], drive.bias.spacing);
    context.monitor.line(text);
  }
  return true;
}

void DoubtConstantBiases(const AdjustmentContext& context, Adjustment* adjustment) {
  const double scale = VarianceScale(*adjustment, context.dataset);
  TryCourses(adjustment, [&](std::size_t d, const CalibrationEquations& equations) {
    adjustment->scale.inflation.points +=
        ScatterOfWander(adjustment->problem, adjustment->state, equations, d, scale);
    return false;
  });
}

void WeakenImuBySlowErrors(const AdjustmentContext& context, Adjustment* adjustment) {
  bool weaker = false;
  for (std::size_t d = 0; d < context.dataset.drives.size(); ++d) {
    ImuSigmaCourse& sigma = adjustment->problem.drives[d].imu_sigma;
    const ImuMeanExcess excess =
        MeasureMeanExcess(EvaluateImuResiduals(context.dataset, adjustment->state, d), sigma);
    adjustment->scale.imu.push_back(excess);
    sigma.usual.gyroscope *= std::sqrt(excess.variance[0]);
    sigma.usual.accelerometer *= std::sqrt(excess.variance[1]);
    for (std::size_t sensor = 0; sensor < 2; ++sensor) {
      if (excess.variance[sensor] <= 1.0) continue;
      weaker = true;
      char text[200];
      std::snprintf(text, sizeof(text), "the %s errs by %.1f times its noise in means over %.0f s",
                    sensor == 0 ? "gyroscope" : "accelerometer", std::sqrt(excess.variance[sensor]),
                    excess.seconds[sensor]);
      context.monitor.line(text);
    }
  }
  if (weaker) adjustment->last_solve = SolveAdjustment(context.monitor.cancellation, adjustment, true);
}

}  // namespace mlic
