#pragma once

#include <string>
#include <vector>

#include "mlic_core/initialization/camera_on_trajectory.h"

namespace mlic {

// What turning alone tells of the cameras.
struct VisualRotations {
  std::vector<CameraCalibration> cameras;  // rotation, time offset; focal length from the field of view
  std::vector<bool> found;
  // The drive turns about one axis only, and no guess says how the camera is turned about it.
  std::vector<bool> open;
  std::vector<double> offset_sigmas;            // s, CameraRotation::offset_sigma; 0 of those that are fixed
  std::vector<Eigen::Vector3d> gyroscope_bias;  // of each drive, rad/s
  std::vector<SensorProblem> problems;          // of the cameras not found
  std::vector<std::string> notes;
};

// Visual rotations between keyframes against the gyroscope's, in turn with the gyroscope's bias, which is
// what the two disagree by in the mean.
VisualRotations AlignWithGyroscope(const Rig& rig, const Dataset& dataset,
                                   const std::vector<CameraStart>& start, const std::vector<TrackSet>& tracks,
                                   const CancellationToken& cancellation);

}  // namespace mlic
