#include "mlic_core/initialization/loose_lidars.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "mlic_core/common/angles.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/geometry/symmetric_matrix.h"

namespace mlic {
namespace {

constexpr double kLoose = 0.3 * kRadiansPerDegree;  // from: guard, the joint calibration bears it and tells
constexpr double kSigmas = 10.0;  // from: guard, odometry errs over seconds alike, sigmas take it as white
// Of a difference of halves along a direction that counts. from: guard, what counts as firm
constexpr double kShown = 0.5 * kLoose;
// Of the whole's rotation, where a half shows nothing. from: guard, far beyond what is looked for
constexpr double kWithin = 10.0 * kRadiansPerDegree;

// Half of the integral of the squared angular rate lies before it.
double MiddleOfTurning(const std::vector<ImuSample>& imu, double start, double end) {
  double whole = 0.0;
  const auto within = [&](const ImuSample& sample) { return sample.time >= start && sample.time <= end; };
  for (const ImuSample& sample : imu) whole += within(sample) ? sample.angular_velocity.squaredNorm() : 0.0;
  double turned = 0.0;
  for (const ImuSample& sample : imu) {
    if (!within(sample)) continue;
    turned += sample.angular_velocity.squaredNorm();
    if (turned >= 0.5 * whole) return sample.time;
  }
  return end;
}

}  // namespace

std::optional<MountTurn> MeasureMountTurn(const std::vector<ImuSample>& imu,
                                          const std::vector<TimedPose>& odometry,
                                          const AngularRateAlignment& whole) {
  if (odometry.empty() || !IsUsable(whole)) return std::nullopt;
  const double cut = MiddleOfTurning(imu, odometry.front().time + whole.time_offset,
                                     odometry.back().time + whole.time_offset) -
                     whole.time_offset;
  const auto middle = std::partition_point(odometry.begin(), odometry.end(),
                                           [&](const TimedPose& pose) { return pose.time < cut; });
  const RotationGuess about{whole.R_imu_lidar, Eigen::Vector3d::Constant(kWithin)};
  const AngularRateAlignment first = AlignAngularRates(imu, {odometry.begin(), middle}, about),
                             second = AlignAngularRates(imu, {middle, odometry.end()}, about);
  if (!IsUsable(first) || !IsUsable(second)) return std::nullopt;
  const Eigen::Vector3d turn = Log(second.R_imu_lidar * first.R_imu_lidar.conjugate());
  // Of the difference: the inverse of the sum of both covariances, which need not exist.
  const Eigen::Matrix3d &a = first.rotation_information, &b = second.rotation_information;
  const Eigen::Matrix3d information = a * (a + b + 1e-6 * Eigen::Matrix3d::Identity()).inverse() * b;
  const SymmetricEigen<3> eigen(0.5 * (information + information.transpose()));
  MountTurn result;
  for (int i = 0; i < 3; ++i) {
    const double value = eigen.eigenvalues()[i];
    if (value * kShown * kShown < 1.0) continue;
    const double along = eigen.eigenvectors().col(i).dot(turn);
    result.angle = std::hypot(result.angle, along);
    result.sigmas = std::hypot(result.sigmas, std::sqrt(value) * along);
  }
  return result;
}

std::vector<bool> FindLoose(const std::vector<std::optional<MountTurn>>& turns) {
  const bool any_firm = std::any_of(turns.begin(), turns.end(), [](const std::optional<MountTurn>& turn) {
    return turn && turn->angle < 0.5 * kLoose;
  });
  std::vector<bool> loose;
  for (const std::optional<MountTurn>& turn : turns) {
    loose.push_back(any_firm && turn && turn->angle > kLoose && turn->sigmas > kSigmas);
  }
  return loose;
}

std::string WhyLoose(const LidarConfig& config) {
  return config.name +
         ": it turned against the IMU within the drive, while another LiDAR did not; its mount came loose: "
         "fix it and record again, or take the part before alone (--start, --duration)";
}

}  // namespace mlic
