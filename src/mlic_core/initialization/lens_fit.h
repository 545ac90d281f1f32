#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "mlic_core/initialization/pixel_matches.h"
#include "mlic_core/sensors/camera_model.h"
#include "mlic_core/trajectory/split_spline.h"

namespace mlic {

// The lens of one camera, how it is turned on the IMU, and when its images are taken. The lens is of the
// unified model (Geyer and Daniilidis, ECCV 2000; Mei and Rives, ICRA 2007), which is double_sphere with xi =
// 0:
//   radius = f sin(theta) / (alpha + (1 - alpha) cos(theta)).
// Its one number alpha, the bend, goes from perspective (0) over stereographic (0.5) to orthographic (1);
// barrel distortion k1 = -0.28 is about 0.6, pincushion distortion below 0.
struct LensHypothesis {
  CameraIntrinsics lens;
  Eigen::Quaterniond R_imu_camera = Eigen::Quaterniond::Identity();
  double time_offset = 0.0;  // s
};

struct LensFit {
  LensHypothesis at;
  double cost = 1.0;  // mean of the robust function over the matches: 0 where all agree, 1 where none does
  double inlier_share = 0.0;  // of matches, with an error below kLensErrorScale
};

// px: the last scale of the robust function, and the error of a match that agrees. Real lenses lie within
// about this of the unified model. from: measured, docs/cameras.md: 0.2 to 3 px.
constexpr double kLensErrorScale = 2.0;

// Least squares over focal length, bend, centre, rotation and time offset of the epipolar errors that are
// left when the camera turns as the trajectory (of each drive) says. For bearings a and b of a match
//   e = t . (R a x b),  R = R_camera_imu R_imu_map(t_b) R_map_imu(t_a) R_imu_camera.
// Each is divided by the sigma that 1 px of noise in both images gives it (Sampson's error, in px: so errors
// under different lenses compare). The direction t of the pair's translation is eliminated by variable
// projection; errors are weighted by Geman and McClure's function, whose scale narrows from what a wrong lens
// makes to kLensErrorScale. half_field_of_view: rad, good to 15 percent. Nothing where the solve fails.
std::optional<LensFit> FitLens(const std::vector<PixelMatches>& pairs,
                               const std::vector<const SplitSpline*>& T_map_imu, double half_field_of_view,
                               const LensHypothesis& start);

// The lens of the unified model with this bend whose left and right edge lie at this angle (rad) from the
// axis; nothing where there is none.
std::optional<CameraIntrinsics> UnifiedLens(int width, int height, double half_field_of_view, double alpha);

}  // namespace mlic
