#pragma once

#include <Eigen/Core>

#include "mlic_core/problem/linearized_problem.h"

namespace mlic {

// What the errors that points share (uneven ground, a beam's pointing, what the trajectory cannot follow) add
// to the scatter of the normal equations' gradient, beyond CorrelationFactor, which is one for all: where
// rough ground shows the height and walls show the rest, the height is known less well. With m_g the part of
// the gradient (control points and planes followed) that comes from a group g of points that one LiDAR puts
// on one plane within a second, and V_g its covariance for white residuals, sum(m_g m_g^T) is compared with
// sum(V_g) (Liang and Zeger, Biometrika 1986): along the directions where their ratio q exceeds `usual` it is
//   sum(V_g)^(1/2) U diag(q / usual - 1) U^T sum(V_g)^(1/2),
// calibration x calibration, of information. There are hundreds of groups for each parameter. Errors of rings
// last for the whole drive and are few, so they are added by what they may be (DoubtOfRings):
// G E[u u^T] G^T / usual, G the gradient's change with them, all else followed. Zero
// where the equations have no solution or no points take part. docs/method.md, section 11.
Eigen::MatrixXd ScatterOfPoints(const LinearizedProblem& linearized, double usual);

}  // namespace mlic
