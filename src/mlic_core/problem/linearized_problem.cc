#include "mlic_core/problem/linearized_problem.h"

#include <cmath>
#include <optional>

#include "mlic_core/problem/linearizer.h"
#include "mlic_core/problem/time_windows.h"
#include "mlic_core/solver/normal_equations.h"

namespace mlic {
namespace {

// rad and m: control points at the ends of a drive that next to nothing shows stay where they are.
constexpr double kShownControlPoint = 0.3;  // from: guard

}  // namespace

LinearizedProblem::LinearizedProblem(const JointProblem& given, const CalibrationState& at)
    : problem(WithShortCouplings(given, at, &origins)), state(at), layout(at, given.estimate_imu_matrices) {
  for (const DriveTerms& drive : given.drives) whole_points.push_back(drive.landmarks.points.size());
  if (problem.fix_trajectory) return;
  std::vector<LandmarkCoupling> couplings;
  const Accumulator sum = Linearize(At(), &couplings);
  const std::optional<ReducedEquations> equations = Reduce(sum, couplings);
  if (!equations) return;
  solved = true;
  information = equations->information;
  knot_response = equations->KnotResponse();
  draw.step = Eigen::VectorXd::Zero(layout.Total());
  draw.step.head(layout.knots) =
      equations->DrawKnots().unaryExpr([](double v) { return std::abs(v) < kShownControlPoint ? v : 0.0; });
  draw.landmarks = LandmarkSteps(couplings, draw.step);
  draw.landmarks_of_opposite = LandmarkSteps(couplings, -draw.step);
}

}  // namespace mlic
