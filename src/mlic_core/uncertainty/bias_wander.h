#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>

#include "mlic_core/problem/joint_solver.h"
#include "mlic_core/sensors/bias_course.h"

namespace mlic {

// Of the steps of a course that nothing is known of beforehand.
constexpr BiasSteps kUnknownSteps{1e3, 1e3};  // rad/s, m/s^2; from: guard, far beyond any

// Constant biases as a course that may wander, over a drive from start to end (s): its knots are all alike.
// None for drives shorter than 10 s.
std::optional<BiasCourse> CourseOf(const BiasCourse& constant, double start, double end);

// What a drive says of how the biases of its IMU wander.
struct BiasEvidence {
  BiasSteps steps;    // as the data have them; some smaller than they show
  double gain = 0.0;  // twice the logarithm of the likelihood's ratio to constant biases

  bool IsShown() const { return gain > 9.0; }  // three sigmas
};

// The steps between a drive's knots as draws from normal distributions about none, one for gyroscope and one
// for accelerometer, whose sigmas are the unknowns: the likelihood's maximum over these, all else of the
// calibration left free (empirical Bayes; docs/method.md, section 10). Steps that the data do not show are as
// large as they may be: the root of the mean of sigma^2 over what IMUs have, each size with its likelihood.
// state: the drive's course is CourseOf constant biases, its steps kUnknownSteps in the problem. equations:
// there. scale: of the variances. Warming up, consumer gyroscopes wander by some mrad/s within a minute.
BiasEvidence EvidenceOfWander(const JointProblem& problem, const CalibrationState& state,
                              const CalibrationEquations& equations, std::size_t drive, double scale);

// What biases that are taken for constant may wander by all the same, as a covariance of the gradient of all
// parameters but the steps, for residuals of variance one: the mean of the steps' products over what IMUs
// have, each size with its likelihood. Arguments: as of EvidenceOfWander.
Eigen::MatrixXd ScatterOfWander(const JointProblem& problem, const CalibrationState& state,
                                const CalibrationEquations& equations, std::size_t drive, double scale);

}  // namespace mlic
