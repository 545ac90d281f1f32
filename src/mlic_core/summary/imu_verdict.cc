#include "mlic_core/summary/imu_verdict.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "mlic_core/geometry/symmetric_matrix.h"
#include "mlic_core/sensors/bias_prior.h"

namespace mlic {
namespace {

// Slow errors of the IMU widen the sigmas; far beyond its noise they are another matter than noise.
void JudgeSlowErrors(std::size_t drive, const ImuMeanExcess& excess, CalibrationResult* result) {
  for (std::size_t sensor = 0; sensor < 2; ++sensor) {
    const double ratio = std::sqrt(excess.variance[sensor]);
    if (ratio <= kImuSlowErrors) continue;
    char text[320];
    std::snprintf(
        text, sizeof(text),
        "drive %zu: means of the %s over %.0f s are off the trajectory by %.1f times what its noise "
        "allows: its bias drifts, its scale or axes are off, or LiDARs or cameras lead astray; record "
        "shorter, after the IMU has warmed up, or try intrinsics: scale_misalignment",
        drive + 1, sensor == 0 ? "gyroscope" : "accelerometer", excess.seconds[sensor], ratio);
    result->reasons.push_back(text);
  }
}

// Unit vectors that span what a projector leaves.
std::vector<Eigen::Vector3d> DirectionsOf(const Eigen::Matrix3d& projector) {
  std::vector<Eigen::Vector3d> directions;
  const SymmetricEigen<3> eigen(projector);
  for (int i = 0; i < 3; ++i) {
    if (eigen.eigenvalues()[i] > 0.5) directions.push_back(eigen.eigenvectors().col(i));
  }
  return directions;
}

}  // namespace

double LargestSlowError(const Adjustment& adjustment) {
  double largest = 0.0;
  for (const ImuMeanExcess& excess : adjustment.scale.imu) {
    for (const double variance : excess.variance) largest = std::max(largest, std::sqrt(variance));
  }
  return largest;
}

std::vector<ImuDisagreement> DisagreementsOfImu(const Dataset& dataset, const Adjustment& adjustment,
                                                double least) {
  std::vector<ImuSigmaCourse> sigmas;
  for (const DriveTerms& drive : adjustment.problem.drives) sigmas.push_back(drive.imu_sigma);
  for (std::size_t d = 0; d < adjustment.scale.imu.size(); ++d) {
    sigmas[d].usual.gyroscope /= std::sqrt(adjustment.scale.imu[d].variance[0]);
    sigmas[d].usual.accelerometer /= std::sqrt(adjustment.scale.imu[d].variance[1]);
  }
  return FindImuDisagreements(dataset, adjustment.state, sigmas, least);
}

void JudgeImuAgreement(const Dataset& dataset, const Adjustment& adjustment, CalibrationResult* result) {
  constexpr double kNotable = 8.0;  // from: definition
  for (std::size_t d = 0; d < adjustment.scale.imu.size(); ++d) {
    JudgeSlowErrors(d, adjustment.scale.imu[d], result);
  }
  for (const ImuDisagreement& found : DisagreementsOfImu(dataset, adjustment, kNotable)) {
    char text[320];
    std::snprintf(text, sizeof(text),
                  "drive %zu, %.0f to %.0f s: the %s contradicts the trajectory by %.2g %s (%.0f times its "
                  "noise): LiDARs or cameras lost their way there, or the IMU errs; leave the stretch out by "
                  "--start and --duration",
                  found.drive + 1, found.begin, found.end, found.of_gyroscope ? "gyroscope" : "accelerometer",
                  found.mean, found.of_gyroscope ? "rad/s" : "m/s^2", found.ratio);
    (found.ratio > kImuContradicts ? result->reasons : result->warnings).push_back(text);
  }
}

QualityCheck CheckImuState(const Adjustment& adjustment) {
  struct Found {
    const char *what, *unit;
    double value, usual;
  };
  std::vector<Found> all;
  if (adjustment.problem.imu.lag_sigma > 0.0) {
    all.push_back({"a lag of its accelerometer", "s", std::abs(adjustment.state.accelerometer_lag),
                   adjustment.problem.imu.lag_sigma});
  }
  for (const DriveState& drive : adjustment.state.drives) {
    const BiasCourse::Bias bias = drive.bias.Mean();
    all.push_back({"a gyroscope bias", "rad/s", bias.head<3>().norm(), kGyroscopeBiasSigma});
    all.push_back({"an accelerometer bias", "m/s^2", bias.tail<3>().norm(), kAccelerometerBiasSigma});
  }
  QualityCheck check;
  check.name = "imu_state";
  check.limit = 5.0;  // from: derivation, beyond any of a million IMUs
  check.unit = "of what is usual";
  check.refuses = true;
  check.remedy = "check the units of the IMU's topic and the guesses; turn about more axes";
  for (const Found& found : all) {
    const double ratio = found.value / found.usual;
    if (ratio <= check.value) continue;
    check.value = ratio;
    char text[200];
    std::snprintf(text, sizeof(text),
                  "the IMU is found to have %s of %.2g %s, as none has: the calibration went astray",
                  found.what, found.value, found.unit);
    check.failure = text;
  }
  return check;
}

ImuAlignment AlignmentOf(const Adjustment& adjustment) {
  ImuAlignment alignment;
  const Eigen::Matrix3d& shown = adjustment.problem.imu.alignment_shown;
  for (int a = 0; a < 3; ++a) {
    alignment.estimated[a] = shown(a, a) > 0.5;
    if (alignment.estimated[a]) alignment.axes = ImuAxes::kGyroscope;
  }
  alignment.held = DirectionsOf(Eigen::Matrix3d::Identity() - shown);
  alignment.of_accelerometer = DirectionsOf(adjustment.state.accelerometer_axes);
  alignment.sigma = adjustment.alignment_covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  return alignment;
}

}  // namespace mlic
