#include "mlic_core/problem/linearized_problem.h"

#include <cmath>
#include <optional>
#include <random>

#include "mlic_core/geometry/symmetric_matrix.h"
#include "mlic_core/problem/linearizer.h"
#include "mlic_core/problem/time_windows.h"
#include "mlic_core/solver/normal_equations.h"

namespace mlic {
namespace {

// rad and m: control points at the ends of a drive that next to nothing shows stay where they are, and so do
// planes along what their points hardly show.
constexpr double kShown = 0.3;  // from: guard
// By how much planes scatter about what a smooth wall would be, against their points' noise. from: measured,
// tilts of patches within 20 deg of the vertical, bodywork among them, paper rig in a yard: 1.7 times where
// LiDARs share them, else 2.1
constexpr double kScatterOfPlanes = 2.0;

// What planes deviate by from their best steps beside the trajectory's; zero of points.
std::vector<Eigen::Vector3d> DrawPlanes(const JointProblem& problem,
                                        const std::vector<LandmarkCoupling>& couplings) {
  std::mt19937_64 engine(2);
  std::normal_distribution<double> draw;
  std::vector<Eigen::Vector3d> deviations(couplings.size(), Eigen::Vector3d::Zero());
  std::size_t first = 0;
  for (const DriveTerms& drive : problem.drives) {
    for (std::size_t p = 0; p < drive.planes.planes.size(); ++p) {
      const SymmetricEigen<3> eigen(couplings[first + p].own);
      for (int k = 0; k < 3; ++k) {
        const double sigma = 1.0 / std::sqrt(std::max(1e-12, eigen.eigenvalues()[k]));
        const double deviation = kScatterOfPlanes * sigma * draw(engine);
        if (std::abs(deviation) < kShown) deviations[first + p] += deviation * eigen.eigenvectors().col(k);
      }
    }
    first += drive.planes.planes.size() + drive.landmarks.points.size();
  }
  return deviations;
}

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
      equations->DrawKnots().unaryExpr([](double v) { return std::abs(v) < kShown ? v : 0.0; });
  draw.landmarks = LandmarkSteps(couplings, draw.step);
  draw.landmarks_of_opposite = LandmarkSteps(couplings, -draw.step);
  const std::vector<Eigen::Vector3d> own = DrawPlanes(problem, couplings);
  for (std::size_t i = 0; i < own.size(); ++i) {
    draw.landmarks[i] += own[i];
    draw.landmarks_of_opposite[i] -= own[i];
  }
}

}  // namespace mlic
