#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "mlic_core/common/time_interval.h"
#include "mlic_core/sensors/measurements.h"
#include "mlic_core/sensors/rig.h"

namespace mlic {

// Samples per second, from the median period.
double ImuRate(const std::vector<ImuSample>& samples);

// Sigmas of single samples along the IMU's axes: rad/s, m/s^2. Axes differ on a vehicle, which shakes more up
// and down than it does forward.
struct ImuSigma {
  Eigen::Vector3d gyroscope = Eigen::Vector3d::Zero();
  Eigen::Vector3d accelerometer = Eigen::Vector3d::Zero();
};

// From the given densities, or else from the third differences of the samples, in which motion slower than a
// tenth of the rate hardly shows: of white noise with sigma s they have the variance 20 s^2. Robust, so that
// shocks do not count. Vibration counts as noise, which is what a trajectory that cannot follow it must see;
// a sensor's own low-pass filter makes the result too small, but never less than 2e-6 rad/s/sqrt(Hz) and 2e-5
// m/s^2/sqrt(Hz).
ImuSigma SampleSigma(const std::vector<ImuSample>& samples, const std::optional<ImuNoise>& given);

// White-noise densities, sigma / sqrt(rate), of the noisiest axis of SampleSigma.
ImuNoise EstimateImuNoise(const std::vector<ImuSample>& samples);

// Where the IMU (on its own clock) is at rest for at least `shortest` seconds, by the spread of rates and
// forces in windows of half a second against the noise: neither exceeds three times the noise's sigma (and
// never counts below 5 mrad/s, 0.05 m/s^2), the mean rate is within 0.05 rad/s of zero, and the force within
// 0.5 m/s^2 of gravity. Smooth straight travel at constant speed looks the same to an IMU.
std::vector<TimeInterval> StaticIntervals(const std::vector<ImuSample>& samples, const ImuNoise& noise,
                                          double shortest = 1.0);

// Mean gyroscope reading over the intervals: the bias, if they are at rest. Zero for no intervals. rad/s.
Eigen::Vector3d MeanAngularVelocity(const std::vector<ImuSample>& samples,
                                    const std::vector<TimeInterval>& intervals);

// How much the motion moves the IMU, along its own axes, about the mean over the drive (which is mostly bias
// and gravity).
struct Excitation {
  Eigen::Vector3d angular_velocity_rms = Eigen::Vector3d::Zero();  // rad/s
  Eigen::Vector3d specific_force_rms = Eigen::Vector3d::Zero();    // m/s^2
  // Principal values (rad/s, ascending) and axes (columns) of the angular velocity: one small value is motion
  // about two axes, two are motion about one.
  Eigen::Vector3d principal_rms = Eigen::Vector3d::Zero();
  Eigen::Matrix3d principal_axes = Eigen::Matrix3d::Identity();
};

Excitation MeasureExcitation(const std::vector<ImuSample>& samples);

}  // namespace mlic
