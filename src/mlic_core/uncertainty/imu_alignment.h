#pragma once

#include <Eigen/Core>

#include "mlic_core/problem/joint_problem.h"
#include "mlic_core/problem/state.h"

namespace mlic {

// Which axes of the accelerometer's rotation to the gyroscope move in a solve, docs/method.md, section 10.
struct AlignmentReview {
  Eigen::Matrix3d held = Eigen::Matrix3d::Identity();        // ImuFreedom::alignment_held
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();  // of the rotation, the prior's where held; rad^2
  // Some axis was free, is told from zero by less than kNoticed sigmas, and costs the sensors much: it need
  // not be tried again.
  bool taken_back = false;
};

// information: of the last solve's calibration (Layout), the residuals' scatter taken out; its covariance of
// the rotation, all else left free, has three principal axes. One is free if
// - its sigma from the data alone is below a third of prior_sigma (rad): else more is known by holding it,
// and
// - the sensors' own rotations about it do not rest on the accelerometer, so that they lose less than half of
//   their accuracy by leaving the axis free; or it was found to be off by more than kNoticed of its sigmas. A
//   car that only yaws has its heading to the IMU from the accelerometer.
// tried: an axis of the latter kind was free in an earlier round and taken back.
AlignmentReview ReviewAlignment(const JointProblem& problem, const CalibrationState& state,
                                const Eigen::MatrixXd& information, double prior_sigma, bool tried);

}  // namespace mlic
