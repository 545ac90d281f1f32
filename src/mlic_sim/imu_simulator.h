#pragma once

#include "mlic_core/common/random.h"
#include "mlic_core/sensors/measurements.h"
#include "mlic_sim/sensor_set.h"
#include "mlic_sim/trajectory.h"

namespace mlic::sim {

// Gravity in the map frame, m/s^2.
inline Eigen::Vector3d MapGravity() { return {0.0, 0.0, -9.81}; }

// Turns true motion into an IMU's readings, sample after sample: measured = matrix * true + bias + noise,
// white noise of the given densities and biases that walk.
class ImuSimulator {
 public:
  ImuSimulator(const SimulatedImu& imu, bool with_noise, Random random)
      : imu_(imu),
        with_noise_(with_noise),
        random_(random),
        gyroscope_bias_(imu.calibration.gyroscope_bias),
        accelerometer_bias_(imu.calibration.accelerometer_bias) {}

  // The sample at `time` (s), where the true motion is `state`. Samples must come at the IMU's rate.
  ImuSample Next(double time, const MotionState& state);

 private:
  Eigen::Vector3d WhiteNoise();

  SimulatedImu imu_;
  bool with_noise_;
  Random random_;
  Eigen::Vector3d gyroscope_bias_, accelerometer_bias_;
};

}  // namespace mlic::sim
