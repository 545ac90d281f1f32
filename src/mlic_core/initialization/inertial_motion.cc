#include "mlic_core/initialization/inertial_motion.h"

#include <memory>

#include "mlic_core/geometry/so3.h"
#include "mlic_core/imu/specific_force_integration.h"

namespace mlic {
namespace {

// Of the lever arm's end, in the IMU's frame at `time`. Rates are means over some samples, which vibrate.
Eigen::Vector3d VelocityOfEnd(const GyroIntegration& gyro, double time, const Eigen::Vector3d& lever_arm) {
  constexpr double kHalfSpan = 0.01;  // s; from: guard, far below the LiDARs' scan period
  const Eigen::Quaterniond turned = gyro.RotationBetween(time - kHalfSpan, time + kHalfSpan);
  return (Log(turned) / (2.0 * kHalfSpan)).cross(lever_arm);
}

// From the LiDAR's clock to the IMU's.
struct ToImuClock {
  ClockDrift clock;
  double offset;  // s

  double operator()(double time) const { return clock.Without(time) + offset; }
};

InertialMotion RotationBy(const std::shared_ptr<const GyroIntegration>& gyro, const ToImuClock& on_imu,
                          const Eigen::Quaterniond& R_imu_lidar) {
  InertialMotion motion;
  motion.rotation = [=](double from, double to) -> std::optional<Eigen::Quaterniond> {
    const double begin = on_imu(from), end = on_imu(to);
    if (!gyro->Covers(begin, end)) return std::nullopt;
    return R_imu_lidar.conjugate() * gyro->RotationBetween(begin, end) * R_imu_lidar;
  };
  return motion;
}

}  // namespace

InertialMotion RotationByImu(const std::vector<ImuSample>& imu, const AngularRateAlignment& alignment,
                             const ClockDrift& clock) {
  return RotationBy(std::make_shared<GyroIntegration>(imu, alignment.gyroscope_bias),
                    {clock, alignment.time_offset}, alignment.R_imu_lidar);
}

InertialMotion MotionByImu(const std::vector<ImuSample>& imu, const AngularRateAlignment& alignment,
                           const GravityLeverArm& arm, const ClockDrift& clock) {
  const auto integration = std::make_shared<const SpecificForceIntegration>(imu, alignment.gyroscope_bias);
  const std::shared_ptr<const GyroIntegration> gyro(integration, &integration->gyro());
  const ToImuClock on_imu{clock, alignment.time_offset};
  InertialMotion motion = RotationBy(gyro, on_imu, arm.R_imu_lidar);
  const Eigen::Matrix3d R_lidar_imu = arm.R_imu_lidar.conjugate().toRotationMatrix();
  const Eigen::Vector3d lever_arm = arm.p_imu_lidar, bias = arm.accelerometer_bias;
  motion.gain = [=](double from, double to) {
    const double begin = on_imu(from), end = on_imu(to);
    const Eigen::Quaterniond turned = gyro->RotationBetween(begin, end);
    const Eigen::Vector3d first = VelocityOfEnd(*gyro, begin, lever_arm);
    const Eigen::Vector3d last = turned * VelocityOfEnd(*gyro, end, lever_arm);
    LinearGain gain;
    gain.velocity = integration->Velocity(begin, end) - integration->VelocityBiasJacobian(begin, end) * bias +
                    last - first;
    gain.position = integration->Position(begin, end) - integration->PositionBiasJacobian(begin, end) * bias +
                    turned * lever_arm - lever_arm - (end - begin) * first;
    gain.velocity = R_lidar_imu * gain.velocity;
    gain.position = R_lidar_imu * gain.position;
    return gain;
  };
  motion.gravity = arm.gravity;
  return motion;
}

}  // namespace mlic
