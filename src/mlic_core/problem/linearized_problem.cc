#include "mlic_core/problem/linearized_problem.h"

#include "mlic_core/problem/linearizer.h"
#include "mlic_core/problem/time_windows.h"

namespace mlic {

LinearizedProblem::LinearizedProblem(const JointProblem& given, const CalibrationState& at)
    : problem(WithShortCouplings(given, at, &origins)), state(at), layout(at, given.estimate_imu_matrices) {
  for (const DriveTerms& drive : given.drives) whole_points.push_back(drive.landmarks.points.size());
  if (problem.fix_trajectory) return;
  const Accumulator sum = Linearize(At(), &couplings);
  equations = Reduce(sum, couplings);
}

}  // namespace mlic
