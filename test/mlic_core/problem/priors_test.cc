#include "mlic_core/problem/priors.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mlic_core/problem/joint_problem.h"
#include "mlic_core/problem/layout.h"
#include "mlic_core/problem/state.h"

namespace mlic {
namespace {

CalibrationState WithFocalLengths(double horizontal, double vertical) {
  CalibrationState state;
  state.cameras.resize(1);
  state.cameras[0].intrinsics.parameters = {horizontal, vertical, 320.0, 240.0, 0.0, 0.0, 0.0, 0.0, 0.0};
  return state;
}

// The step of both focal lengths that data with the given sigma (px) and the prior take together, the data
// being where the state is.
Eigen::Vector2d Step(const CalibrationState& state, double sigma, bool square = true) {
  const Layout layout(state, false);
  Eigen::MatrixXd information;
  Eigen::VectorXd gradient;
  JointProblem problem;
  problem.cameras.resize(1);
  problem.cameras[0].fixed.square_pixels = square;
  CalibrationPrior(problem, state, layout, &information, &gradient);
  const int at = layout.Intrinsics(0);
  const Eigen::Matrix2d data = Eigen::Matrix2d::Identity() / (sigma * sigma);
  return -(information.block<2, 2>(at, at) + data).ldlt().solve(gradient.segment<2>(at));
}

TEST(CalibrationPrior, DrawsPixelsToSquareWhereDataSayLittle) {
  const CalibrationState state = WithFocalLengths(500.0, 496.0);
  const Eigen::Vector2d far = Step(state, 100.0);
  EXPECT_NEAR(far[0], -2.0, 1e-3);
  EXPECT_NEAR(far[1], 2.0, 1e-3);
  EXPECT_EQ(Step(state, 100.0, false).norm(), 0.0);
}

TEST(CalibrationPrior, LeavesAnamorphicPixelsAlone) {
  EXPECT_EQ(Step(WithFocalLengths(500.0, 540.0), 100.0).norm(), 0.0);
}

}  // namespace
}  // namespace mlic
