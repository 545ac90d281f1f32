#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "mlic_core/initialization/camera_rotation.h"
#include "mlic_core/sensors/rig.h"
#include "mlic_core/trajectory/split_spline.h"

namespace mlic {

// p_imu_camera (m) from the directions of a camera's motions, its rotation and time offset given: between
// times a and b, with d the direction in frame b and (R_a, p_a), (R_b, p_b) the IMU's poses, the camera moves
// by
//   R_b^T (p_b - p_a) + (I - R_b^T R_a) p_imu_camera  =  lambda R_imu_camera d,  lambda > 0 unknown,
// so that what is across R_imu_camera d must vanish. Linear in p_imu_camera, re-weighted to angles and robust
// (Tukey). The guess is a prior; without one the prior is zero with 10 m. Motions by less than 5 cm have no
// say. None where fewer than ten do. T_map_imu: of each drive.
std::optional<Eigen::Vector3d> CameraLeverArm(const std::vector<VisualMotion>& motions,
                                              const std::vector<const SplitSpline*>& T_map_imu,
                                              const Eigen::Quaterniond& R_imu_camera, double time_offset,
                                              const std::optional<ExtrinsicGuess>& guess);

}  // namespace mlic
