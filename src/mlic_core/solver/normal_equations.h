#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "mlic_core/solver/accumulator.h"
#include "mlic_core/solver/envelope_cholesky.h"

namespace mlic {

struct NormalSolution {
  bool solved = false;
  Eigen::VectorXd delta;  // control points, then calibration
  // By how much the step should lower the data's cost, landmarks being moved to their best before it.
  double predicted_decrease = 0.0;
  // Of the calibration, control points and landmarks left free.
  Eigen::MatrixXd information;
  Eigen::VectorXd gradient;
};

// prior: added to the corner's diagonal block after the information is taken (information is of the data
// alone). prior_gradient belongs to it. damping: relative, added to every diagonal (Marquardt). hold_knots:
// the trajectory is held, only the calibration and the landmarks move. free_calibration: mask (calibration)
// of what may move.
NormalSolution SolveNormalEquations(const Accumulator& sum, const std::vector<LandmarkCoupling>& landmarks,
                                    const Eigen::MatrixXd& prior, const Eigen::VectorXd& prior_gradient,
                                    const std::vector<bool>& free_calibration, double damping,
                                    bool hold_knots);

// The step of the calibration alone, of its information and gradient; arguments as above.
Eigen::VectorXd SolveCalibration(const Eigen::MatrixXd& information, const Eigen::VectorXd& gradient,
                                 const Eigen::MatrixXd& prior, const Eigen::VectorXd& prior_gradient,
                                 const std::vector<bool>& free_calibration, double damping);

// The normal equations with control points and landmarks eliminated.
struct ReducedEquations {
  // Draws a deviation of the control points from the normal distribution that the equations give them with
  // the calibration held and landmarks left free. The same for the same equations.
  Eigen::VectorXd DrawKnots() const;

  // How control points follow the calibration, landmarks left free (calibration x knots): a step of the
  // calibration moves their best places by minus the transpose of this times the step.
  Eigen::MatrixXd KnotResponse() const;

  EnvelopeMatrix factor;        // of the control points, landmarks left free
  Eigen::MatrixXd information;  // of the calibration, as in NormalSolution
};

// Nothing where the equations have no solution.
std::optional<ReducedEquations> Reduce(const Accumulator& sum,
                                       const std::vector<LandmarkCoupling>& landmarks);

// The damping after a step that was taken, none below 1e-9; gain: by how much the cost fell, of what the
// equations promised. It falls by 100 where they told it to a quarter, else by 10: valleys along directions
// that the data hardly show bend within an undamped step, and damping as for strong ones hardly moves there.
double DampingAfter(double damping, double gain);

}  // namespace mlic
