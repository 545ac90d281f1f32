#pragma once

#include <Eigen/Core>

#include "mlic_core/problem/joint_problem.h"
#include "mlic_core/problem/state.h"

namespace mlic {

// What a solve says of the accelerometer's rotation to the gyroscope, docs/method.md, section 10.
struct AlignmentReview {
  Eigen::Matrix3d shown = Eigen::Matrix3d::Zero();               // ImuFreedom::alignment_shown
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();          // of the rotation, with its prior; rad^2
  Eigen::Matrix3d accelerometer_axes = Eigen::Matrix3d::Zero();  // CalibrationState's, from now on
};

// information: of the last solve's calibration (Layout), the residuals' scatter taken out.
// Of the rotation's covariance from the data alone, all else left free, a principal axis is shown if its
// sigma is below a third of prior_sigma (rad): elsewhere more is known of soldered parts. The IMU's axes are
// the accelerometer's about directions about which the sensors' rotations to them have the smaller sigma: a
// car that only yaws has its heading from the accelerometer.
AlignmentReview ReviewAlignment(const JointProblem& problem, const CalibrationState& state,
                                const Eigen::MatrixXd& information, double prior_sigma);

}  // namespace mlic
