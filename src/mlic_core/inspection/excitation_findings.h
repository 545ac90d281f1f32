#pragma once

#include <string>
#include <vector>

#include "mlic_core/inspection/finding.h"
#include "mlic_core/sensors/measurements.h"

namespace mlic {

// How much a part of the drive turns and shakes the IMU, along its axes.
struct MotionPart {
  double begin = 0.0, end = 0.0;                                   // s after the first sample
  Eigen::Vector3d angular_velocity_rms = Eigen::Vector3d::Zero();  // rad/s, bias taken out
  Eigen::Vector3d specific_force_rms = Eigen::Vector3d::Zero();    // m/s^2, about the part's mean
  double rest = 0.0;                                               // s of it at rest
};

// The drive in parts of `length` seconds. bias: of the gyroscope, rad/s.
std::vector<MotionPart> MotionOverTime(const std::vector<ImuSample>& samples, const Eigen::Vector3d& bias,
                                       double length);

// Mean reading at rest, or over the drive where it never rests: rad/s.
Eigen::Vector3d RoughGyroscopeBias(const std::vector<ImuSample>& samples);

// Whether it turns about two axes or more, or about one, or not at all; rest and length.
Findings ExcitationFindings(const std::vector<ImuSample>& samples);

// The parts as a table for people, one line each, under a line of headings.
std::vector<std::string> MotionTable(const std::vector<MotionPart>& parts);

}  // namespace mlic
