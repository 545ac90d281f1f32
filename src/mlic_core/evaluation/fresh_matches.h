#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "mlic_core/common/progress.h"
#include "mlic_core/result/result.h"
#include "mlic_core/sensors/measurements.h"

namespace mlic {

// One point seen by two cameras, each in an image of its own.
struct FreshMatch {
  std::string camera_a, camera_b;
  TimeNs stamp_a = 0, stamp_b = 0;  // of the images, each on its camera's clock
  Eigen::Vector2d pixel_a = Eigen::Vector2d::Zero(), pixel_b = Eigen::Vector2d::Zero();
};

struct FreshMatchOptions {
  // from: definition of the figure of merit.
  int image_pairs = 12;             // of two cameras, spread over the drive
  double largest_time_apart = 0.1;  // s, of two images; from: definition of the figure of merit
  // from: definition of the figure of merit.
  double least_overlap = 0.2;  // share of the view that two images have in common
  // from: definition of the figure of merit.
  double nearest = 3.0;    // m, the depths of the scene that the overlap is judged at
  double farthest = 30.0;  // from: definition of the figure of merit
  // Matches are looked for this near to the epipolar line that the calibration predicts (rad), wide enough
  // not to hide its errors, and have to agree with one geometry of the two images, found from themselves, to
  // this many pixels.
  double search_error = 0.05;         // from: definition of the figure of merit
  double largest_disagreement = 3.0;  // from: definition of the figure of merit
  // from: definition of the figure of merit.
  double least_baseline = 0.03;  // m; nearer centres have no epipolar lines
  int fewest_matches = 15;       // of two images; from: definition of the figure of merit
};

// Matches between cameras that the solve did not use: in images none of which is a keyframe. drive.cameras[i]
// is the camera of that name in `names`; calibration and trajectory (T_map_imu) say which images share their
// view. Cameras without intrinsics in the calibration are left out.
std::vector<FreshMatch> FindFreshMatches(const Drive& drive, const std::vector<std::string>& names,
                                         const CalibrationResult& calibration,
                                         const std::vector<StampedPose>& trajectory,
                                         const std::vector<CameraKeyframes>& keyframes,
                                         const FreshMatchOptions& options,
                                         const CancellationToken& cancellation);

// T_map_camera of a row (px) of an image with this stamp; false where the trajectory does not reach.
bool PoseOfRow(const SensorResult& camera, const std::vector<StampedPose>& trajectory, TimeNs stamp,
               double row, RigidTransform* T_map_camera);

// The camera of that name with intrinsics; null where there is none.
const SensorResult* FindCamera(const CalibrationResult& calibration, const std::string& name);

}  // namespace mlic
