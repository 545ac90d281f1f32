#pragma once

#include <optional>
#include <string>
#include <vector>

#include "mlic_core/common/progress.h"
#include "mlic_core/common/time_interval.h"
#include "mlic_core/imu/angular_rate_alignment.h"
#include "mlic_core/inspection/finding.h"
#include "mlic_core/inspection/pose_information.h"
#include "mlic_core/sensors/measurements.h"
#include "mlic_core/sensors/rig.h"
#include "mlic_core/sensors/sensor_frames.h"

namespace mlic {

// The `length` seconds of the drive that turn most about two axes, on the IMU's clock; all of a shorter one.
TimeInterval LiveliestStretch(const std::vector<ImuSample>& imu, double length);

// How one LiDAR turns beside the IMU in a stretch of the drive, by its own odometry and without its guess.
struct LidarRotation {
  std::string name;
  std::optional<ExtrinsicGuess> guess;
  AngularRateAlignment alignment;
  std::optional<PoseInformation> pose_information;  // along the LiDAR's axes
};

// recording: its times are seconds on the epoch of the IMU's.
LidarRotation MeasureRotation(const LidarConfig& config, const LidarRecording& recording,
                              const std::vector<ImuSample>& imu, const CancellationToken& cancellation);

// Whether each LiDAR turns as the IMU does, and as its guess says; where it does not, whether it turns as
// another one's guess says (their topics look exchanged) or as the inverse of its own.
Findings RotationFindings(const std::vector<LidarRotation>& lidars);

// How well all of them together tell the rig's poses, along the IMU's axes; the typical noise where none that
// has a rotation to the IMU, measured or guessed, tells any. Lever arms are taken for short.
PoseNoise PoseNoiseOf(const std::vector<LidarRotation>& lidars);

// Sensors whose messages carry each other's frames: their topics look exchanged.
Findings FrameFindings(const std::vector<SensorFrame>& sensors);

}  // namespace mlic
