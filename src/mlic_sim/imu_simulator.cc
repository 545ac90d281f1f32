#include "mlic_sim/imu_simulator.h"

#include <cmath>

namespace mlic::sim {

Eigen::Vector3d ImuSimulator::WhiteNoise() {
  const double x = random_.Normal(), y = random_.Normal(), z = random_.Normal();
  return {x, y, z};
}

ImuSample ImuSimulator::Next(double time, const MotionState& state) {
  const ImuCalibration& calibration = imu_.calibration;
  const Eigen::Vector3d specific_force =
      state.T_map_imu.rotation.conjugate() * (state.acceleration - MapGravity());
  ImuSample sample;
  sample.time = time;
  sample.angular_velocity = calibration.gyroscope_matrix * state.angular_velocity + gyroscope_bias_;
  sample.specific_force = calibration.accelerometer_matrix * specific_force + accelerometer_bias_;
  if (with_noise_) {
    const double per_sample = std::sqrt(imu_.rate), per_step = 1.0 / per_sample;
    sample.angular_velocity += imu_.noise.gyroscope * per_sample * WhiteNoise();
    sample.specific_force += imu_.noise.accelerometer * per_sample * WhiteNoise();
    gyroscope_bias_ += imu_.gyroscope_walk * per_step * WhiteNoise();
    accelerometer_bias_ += imu_.accelerometer_walk * per_step * WhiteNoise();
  }
  return sample;
}

}  // namespace mlic::sim
