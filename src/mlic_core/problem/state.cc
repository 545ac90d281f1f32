#include "mlic_core/problem/state.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mlic_core/sensors/imu_matrices.h"

namespace mlic {
namespace {

bool IsFinite(const SensorCalibration& sensor) {
  return sensor.T_imu_sensor.rotation.coeffs().allFinite() && sensor.T_imu_sensor.translation.allFinite() &&
         std::isfinite(sensor.time_offset) && std::isfinite(sensor.clock_drift.value_or(0.0));
}

bool IsFinite(const CameraCalibration& camera) {
  const std::vector<double>& parameters = camera.intrinsics.parameters;
  return IsFinite(camera.sensor) && std::isfinite(camera.readout) &&
         std::all_of(parameters.begin(), parameters.end(), [](double value) { return std::isfinite(value); });
}

bool IsFinite(const DriveState& drive) {
  const auto& rotations = drive.trajectory.rotation.control_points();
  const auto& positions = drive.trajectory.position.control_points();
  const auto& biases = drive.bias.knots;
  return std::all_of(biases.begin(), biases.end(),
                     [](const BiasCourse::Bias& bias) { return bias.allFinite(); }) &&
         std::all_of(rotations.begin(), rotations.end(),
                     [](const Eigen::Quaterniond& rotation) { return rotation.coeffs().allFinite(); }) &&
         std::all_of(positions.begin(), positions.end(),
                     [](const Eigen::Vector3d& position) { return position.allFinite(); });
}

}  // namespace

void SetAccelerometerAxes(const Eigen::Matrix3d& directions, CalibrationState* state) {
  const Eigen::Matrix3d of_accelerometer = SplitAccelerometerMatrix(state->accelerometer_matrix).rotation;
  const Eigen::Matrix3d of_gyroscope = SplitGyroscopeMatrix(state->gyroscope_matrix).rotation;
  // From the gyroscope's axes to the new ones: what of the rotation to the accelerometer's is about the
  // directions.
  const Eigen::Quaterniond twist = TwistAbout(directions, of_accelerometer * of_gyroscope.transpose());
  const Eigen::Quaterniond turn = (twist * Eigen::Quaterniond(of_gyroscope)).normalized();
  const auto turn_sensor = [&](SensorCalibration* sensor) {
    RigidTransform& T = sensor->T_imu_sensor;
    T = {(turn * T.rotation).normalized(), turn * T.translation};
  };
  for (SensorCalibration& lidar : state->lidars) turn_sensor(&lidar);
  for (CameraCalibration& camera : state->cameras) turn_sensor(&camera.sensor);
  for (DriveState& drive : state->drives) {
    std::vector<Eigen::Quaterniond> rotations = drive.trajectory.rotation.control_points();
    for (Eigen::Quaterniond& rotation : rotations) rotation = (rotation * turn.conjugate()).normalized();
    drive.trajectory.rotation = So3Spline(drive.trajectory.rotation.knots(), std::move(rotations));
  }
  state->gyroscope_matrix *= turn.conjugate().toRotationMatrix();
  state->accelerometer_matrix *= turn.conjugate().toRotationMatrix();
  state->accelerometer_axes = directions;
}

bool IsFinite(const CalibrationState& state) {
  const auto finite = [](const auto& part) { return IsFinite(part); };
  return state.gyroscope_matrix.allFinite() && state.accelerometer_matrix.allFinite() &&
         std::isfinite(state.gravity) && std::isfinite(state.accelerometer_lag) &&
         std::all_of(state.lidars.begin(), state.lidars.end(), finite) &&
         std::all_of(state.cameras.begin(), state.cameras.end(), finite) &&
         std::all_of(state.drives.begin(), state.drives.end(), finite);
}

}  // namespace mlic
