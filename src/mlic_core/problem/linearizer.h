#pragma once

#include <vector>

#include "mlic_core/problem/linear_terms.h"

namespace mlic {

// The normal equations of the joint problem at a state: all that the problem says but for the priors.
// landmarks: for each drive the planes' couplings, then the points'.
Accumulator Linearize(const LinearizationPoint& at, std::vector<LandmarkCoupling>* landmarks);

// The cost of Linearize alone, several times faster.
double Cost(const LinearizationPoint& at);

// The landmarks' own steps after the control points' and the calibration's (delta).
std::vector<Eigen::Vector3d> LandmarkSteps(const std::vector<LandmarkCoupling>& couplings,
                                           const Eigen::VectorXd& delta);
void MoveLandmarks(const std::vector<Eigen::Vector3d>& steps, JointProblem* problem);

}  // namespace mlic
