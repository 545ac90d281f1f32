#pragma once

#include <Eigen/Core>

#include "mlic_core/problem/joint_problem.h"
#include "mlic_core/problem/layout.h"

namespace mlic {

// The prior's information and gradient at the state, calibration parameters only.
void CalibrationPrior(const JointProblem& problem, const CalibrationState& state, const Layout& layout,
                      Eigen::MatrixXd* information, Eigen::VectorXd* gradient);

// What of an IMU moves before its drive has said more: gravity, where the rig file does not give it, and the
// accelerometer's lag and its rotation to the gyroscope. Held, its axes bend the trajectory by far more than
// points' noise, and look like a lag while the rig turns. Which axes the drive shows is not known yet: the
// prior serves about all.
ImuFreedom FreedomOf(const ImuConfig& imu);

// px, of a lens's centre from the middle of its image, or from what the rig file gives.
double UsualCentreSigma(const CameraIntrinsics& intrinsics);

// Adds what keeps JointProblem::held_translations: a prior along each row far stiffer than anything else. It
// is no knowledge, and no part of covariances.
void AddHeldTranslations(const JointProblem& problem, const CalibrationState& state,
                         Eigen::MatrixXd* information, Eigen::VectorXd* gradient);

}  // namespace mlic
