#pragma once

#include <Eigen/Core>

#include "mlic_core/geometry/rigid_transform.h"

namespace mlic {

constexpr int kMostThreePointPoses = 4;  // from: paper, Grunert 1841: a quartic

// The poses T_camera_body of a camera that sees three points (body frame, m) along three bearings (unit,
// camera frame, any angle from the axis). Returns how many (0 to 4) were written to `poses`. The distances l
// to the points meet two homogeneous quadratic equations; a singular combination of the two is a pair of
// planes through the origin of l, after Persson and Nordberg, "Lambda Twist", ECCV 2018.
int SolveThreePoint(const Eigen::Vector3d (&bearings)[3], const Eigen::Vector3d (&points)[3],
                    RigidTransform (&poses)[kMostThreePointPoses]);

}  // namespace mlic
