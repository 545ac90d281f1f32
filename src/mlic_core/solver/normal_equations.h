#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "mlic_core/solver/accumulator.h"

namespace mlic {

struct NormalSolution {
  bool solved = false;
  Eigen::VectorXd delta;  // control points, then calibration
  // By how much the step should lower the data's cost, landmarks being moved to their best before it.
  double predicted_decrease = 0.0;
  Eigen::MatrixXd information;  // of the calibration, control points and landmarks left free
};

// prior: added to the corner's diagonal block after the information is taken (information is of the data
// alone). prior_gradient belongs to it. damping: relative, added to every diagonal (Marquardt). hold_knots:
// the trajectory is held, only the calibration and the landmarks move. free_calibration: mask (calibration)
// of what may move.
NormalSolution SolveNormalEquations(const Accumulator& sum, const std::vector<LandmarkCoupling>& landmarks,
                                    const Eigen::MatrixXd& prior, const Eigen::VectorXd& prior_gradient,
                                    const std::vector<bool>& free_calibration, double damping,
                                    bool hold_knots);

// The calibration's information alone, as in NormalSolution; nothing where the equations have no solution.
std::optional<Eigen::MatrixXd> CalibrationInformation(const Accumulator& sum,
                                                      const std::vector<LandmarkCoupling>& landmarks);

struct KnotsByNoise {
  Eigen::VectorXd deviation;    // of the control points
  Eigen::MatrixXd information;  // of the calibration
};

// Draws a deviation of the control points from the normal distribution that the equations give them with the
// calibration held and landmarks left free. The same for the same equations; nothing where they have no
// solution.
std::optional<KnotsByNoise> DrawKnots(const Accumulator& sum, const std::vector<LandmarkCoupling>& landmarks);

// How control points follow the calibration, landmarks left free (calibration x knots): a step of the
// calibration moves their best places by minus the transpose of this times the step. Nothing where the
// equations have no solution.
std::optional<Eigen::MatrixXd> KnotResponse(const Accumulator& sum,
                                            const std::vector<LandmarkCoupling>& landmarks);

}  // namespace mlic
