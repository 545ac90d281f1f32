#pragma once

#include <optional>
#include <vector>

#include "mlic_core/initialization/pixel_matches.h"
#include "mlic_core/sensors/rig.h"
#include "mlic_core/trajectory/split_spline.h"

namespace mlic {

// The motion of one camera between two of its keyframes, as its images show it.
struct VisualMotion {
  std::size_t drive = 0;
  double time_a = 0.0;  // camera clock
  double time_b = 0.0;
  Eigen::Matrix3d R_a_b = Eigen::Matrix3d::Identity();
  Eigen::Vector3d direction =
      Eigen::Vector3d::Zero();  // of the motion from a to b in frame b; zero: not shown
};

// Motions between these keyframes of one camera. largest_error: px, of an observation that agrees; the
// intrinsics may be rough.
std::vector<VisualMotion> VisualMotions(const std::vector<PixelMatches>& pairs,
                                        const CameraIntrinsics& intrinsics, double largest_error);

// 1/rad, of CameraRotation::weakest_axis: below, directions of motion tell what rotations do not.
constexpr double kWeakAxis = 20.0;

struct CameraRotation {
  bool valid = false;
  Eigen::Quaterniond R_imu_camera = Eigen::Quaterniond::Identity();
  double time_offset = 0.0;  // s
  // s, of the time offset; where the drive turns evenly or not at all, far beyond any that is looked for
  double offset_sigma = 0.0;
  // What the focal length has to be multiplied by for the visual rotations to be as large as the IMU's; 1
  // where the motion does not show it.
  double focal_ratio = 1.0;
  double cost = 0.0;          // mean square of the disagreement, truncated, focal ratio left out, rad^2
  double residual = 0.0;      // median angle between visual rotations and the trajectory's, rad
  double inlier_share = 0.0;  // of motions that agree to 3 deg
  double weakest_axis = 0.0;  // 1/rad, root of the rotation information's second eigenvalue; small: turns
                              // about one axis only
};

// Rotation and time offset (within +-1 s of the given one) that make the visual rotations agree best with the
// trajectory's. Where it turns about one axis only, the directions of motion tell what is left; the guess is
// a prior.
CameraRotation AlignCameraRotation(const std::vector<VisualMotion>& motions,
                                   const std::vector<const SplitSpline*>& T_map_imu,
                                   const std::optional<ExtrinsicGuess>& guess,
                                   const std::optional<double>& time_offset);

}  // namespace mlic
