#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace mlic {

// Rotations. Vectors of so(3) are in radians; perturbations are on the right, R * Exp(delta), unless a name
// says otherwise. Formulas: Sola et al., "A micro Lie theory for state estimation in robotics", 2018.

// Cross-product matrix: Hat(a) * b = a x b.
Eigen::Matrix3d Hat(const Eigen::Vector3d& v);

Eigen::Quaterniond ExpQuaternion(const Eigen::Vector3d& v);
Eigen::Matrix3d ExpMatrix(const Eigen::Vector3d& v);

// The logarithm with the angle in [0, pi]; precise for tiny angles as well.
Eigen::Vector3d Log(const Eigen::Quaterniond& q);
Eigen::Vector3d Log(const Eigen::Matrix3d& R);

// The inverse of J in Exp(v + e) = Exp(v) * Exp(J * e), to first order in e; the left one's is its transpose.
Eigen::Matrix3d RightJacobianInverse(const Eigen::Vector3d& v);

// Fixed-axis roll, pitch, yaw as in URDF: R = Rz(yaw) * Ry(pitch) * Rx(roll). Radians.
Eigen::Quaterniond FromRollPitchYaw(const Eigen::Vector3d& rpy);
Eigen::Vector3d ToRollPitchYaw(const Eigen::Quaterniond& q);

// Geodesic angle between two rotations, radians.
double AngleBetween(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b);

}  // namespace mlic
