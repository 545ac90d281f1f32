#pragma once

#include <string>

#include "mlic_core/problem/joint_problem.h"
#include "mlic_core/problem/state.h"

namespace mlic {

// A simulated drive's joint problem: map and association drawn at the truth, the start disturbed by
// 2 mrad, 5 mm and 0.3 ms for each sensor (one sigma of each component), which both solvers start from.
struct JointSolverCase {
  Dataset dataset;  // IMU only
  CalibrationState start;
  JointProblem problem;  // its dataset is not set
};

// sensors: a file of config/simulation (from the repository root); "car" or "hand-held" motion. duration: s.
JointSolverCase MakeJointSolverCase(const std::string& sensors, bool car, double duration);

}  // namespace mlic
