#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <vector>

#include "mlic_core/common/random.h"
#include "mlic_core/sensors/measurements.h"
#include "mlic_sim/sensor_set.h"
#include "mlic_sim/trajectory.h"

namespace mlic::sim {

// By how much a low-pass delays slow signals, s: sqrt(2) / (2 pi f_c) for a second-order Butterworth; 0
// without one.
double GroupDelay(double low_pass, double rate);

// A second-order Butterworth low-pass, H(s) = w^2 / (s^2 + sqrt(2) w s + w^2), of three signals that run
// straight between two steps.
class ButterworthFilter {
 public:
  // cut_off: Hz; step: s between two inputs. The filter starts as if `start` had always been.
  ButterworthFilter(double cut_off, double step, const Eigen::Vector3d& start);

  Eigen::Vector3d Next(const Eigen::Vector3d& input);

 private:
  Eigen::Matrix2d transition_;
  Eigen::Vector2d of_before_, of_now_;  // how two inputs act on the state
  Eigen::Matrix<double, 2, 3> state_;   // output and its derivative
  Eigen::Vector3d before_;
};

// Turns true motion into an IMU's readings, sample after sample: measured = matrix * true + bias + noise,
// white noise of the given densities and biases that walk and settle; with a low-pass, all of it but the
// biases goes through it.
class ImuSimulator {
 public:
  using Motion = std::function<MotionState(double time)>;

  ImuSimulator(const SimulatedImu& imu, bool with_noise, Random random);

  // The sample at `time` (s) of a rig that moves as `motion` says, also before the first sample. Samples must
  // come at the IMU's rate.
  ImuSample Next(double time, const Motion& motion);

 private:
  struct Line {
    double frequency;                                  // rad/s
    Eigen::Vector3d angular_velocity, specific_force;  // amplitudes
    double gyroscope_phase, accelerometer_phase;       // rad
  };

  Eigen::Vector3d WhiteNoise();
  // Of the motion, with matrices and without biases.
  ImuSample TrueReading(double time, const Motion& motion) const;
  // What vibration adds, behind the filters.
  void AddVibration(ImuSample* sample) const;
  void StartFilters(double time, const Motion& motion);
  // Replaces what has a filter by what comes out of it, noise included.
  void Filter(double time, const Motion& motion, ImuSample* reading);

  SimulatedImu imu_;
  bool with_noise_;
  Random random_;
  Eigen::Vector3d gyroscope_bias_, accelerometer_bias_;
  std::vector<Line> lines_;
  // From the first sample on.
  std::optional<ButterworthFilter> gyroscope_filter_, accelerometer_filter_;
  double filtered_until_ = 0.0;  // s
};

}  // namespace mlic::sim
