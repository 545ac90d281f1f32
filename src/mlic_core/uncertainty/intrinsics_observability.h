#pragma once

#include <Eigen/Core>
#include <vector>

#include "mlic_core/problem/joint_problem.h"
#include "mlic_core/problem/layout.h"
#include "mlic_core/problem/state.h"

namespace mlic {

// px, rms over all observations of a camera: what they may err by in a smooth pattern over the image that
// looks like a part of the lens model, before that is measured (ImagePattern; docs/cameras.md).
constexpr double kPatternError = 0.01;  // from: measured, parts of real images err by 0.003 to 0.02 px

// For each parameter by how many pixels the image moves, in the mean over the image, for a change of one.
std::vector<double> ImageDisplacements(const CameraIntrinsics& intrinsics);

// By how many of its sigmas a parameter of each camera may be off, at most, if all observations of points err
// by one pixel in some common pattern: for errors e and weights W of the observations, J the parameter's row
// of the solution, |J W e| <= sqrt(e^T W e) sigma (Cauchy-Schwarz). Grows with the number of observations as
// sigma shrinks.
std::vector<double> PatternSensitivity(const std::vector<DriveTerms>& drives, std::size_t cameras);

// Decides which intrinsics the data determine. information: of the calibration (Layout) with what belongs to
// it of the priors; the scatter of the residuals is taken out already. A parameter is held when one sigma of
// it, with the camera's other intrinsics moving as they are correlated with it, moves the image by more than
// `limit` px in the mean, to first order or as a whole (terms that undo each other may, to first order,
// change by more than the lens has); higher terms of the distortion first, one after the other, as each one
// that is held tells more of the others. The radial terms of the rational model are not held: nothing is held
// that has its usual size as a prior. Both tangential terms are held too when a pattern of errors that real
// lenses and features leave (sensitivity: PatternSensitivity) can fake as much of one of them as lenses have:
// in an image much wider than high, of a car that turns about the vertical, they, the centre and the pitch
// look alike, and more observations do not help. A centre is not held: what earlier rounds left it at may be
// tens of pixels from what the data say, and the rotation with it. It moves on, with its usual distance from
// the middle of the image as a prior. Where the data tell the ratio of the focal lengths to less than half a
// thousandth, pixels are taken for square: a car hardly pitches, and its vertical focal length rests on how
// well its trajectory has that little. information must be without these priors. start: what is held anyway.
std::vector<FixedCameraParameters> HoldUndeterminedIntrinsics(const Eigen::MatrixXd& information,
                                                              const CalibrationState& state,
                                                              const Layout& layout,
                                                              const std::vector<FixedCameraParameters>& start,
                                                              const std::vector<double>& sensitivity,
                                                              double limit = 1.0);

// Tangential terms that are held stand at what the rig file gives or at zero, about which they have their
// variance, not where a round that let them move left them: there they would keep what they imitate of the
// centre. A lens of which everything is held stays as it is.
void PlaceHeldTangentialTerms(const std::vector<CameraTerms>& cameras, CalibrationState* state);

// The information with all that is held taken as known: for covariances.
Eigen::MatrixXd InformationWithFixed(const Eigen::MatrixXd& information, const CalibrationState& state,
                                     const Layout& layout, const std::vector<FixedCameraParameters>& held);

// The information without what is held, plus `prior`, for covariances that have the doubt of what is held.
// Terms of the distortion have a variance of their usual size: the covariance of all else then is
// A^-1 + A^-1 B Q B^T A^-1, as of parameters that are considered but not estimated (Schmidt), with A the
// information of what is estimated, B how `information` couples it to them and Q their variance. A lens of
// which everything is held is taken as known.
Eigen::MatrixXd WithVarianceOfHeldTerms(const Eigen::MatrixXd& information, const CalibrationState& state,
                                        const Layout& layout, const std::vector<FixedCameraParameters>& held,
                                        const Eigen::MatrixXd& prior);

// Steps of all calibration parameters that count as large (rotation, translation, offset: the limits of
// observability; intrinsics: 1 px in the mean over the image; others: 1): scales for inverting information.
Eigen::VectorXd CalibrationLimits(const CalibrationState& state, const Layout& layout);

}  // namespace mlic
