#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "mlic_core/geometry/timed_pose.h"
#include "mlic_core/sensors/measurements.h"

namespace mlic {

// What one second of a sensor's observations tells of its pose in the map: of a small rotation and of a
// translation along the sensor's own axes, 1/rad^2, 1/(rad m), 1/m^2.
using PoseInformation = Eigen::Matrix<double, 6, 6>;

// Of a LiDAR's points on the planes of a map that is laid out by these poses (T_odom_lidar in the middle of
// each scan, in order), with as many points of a scan as a calibration takes and the scatter that they have
// about the planes. Nothing where they are too few.
std::optional<PoseInformation> MeasurePoseInformation(const LidarRecording& recording,
                                                      const std::vector<TimedPose>& poses);

// White noise of poses that are known that well: covariances of small rotations (rad^2) and positions (m^2)
// of poses taken once a second; of poses taken f times a second they are f times larger.
struct PoseNoise {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d position = Eigen::Matrix3d::Zero();
  bool measured = false;  // from the recording, not the typical one
};

// Where nothing was measured: 3e-5 rad and 0.3 mm at 10 Hz.
PoseNoise TypicalPoseNoise();

PoseNoise NoiseOfPoses(const PoseInformation& information);

}  // namespace mlic
