#include "mlic_core/problem/priors.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mlic_core/problem/joint_problem.h"
#include "mlic_core/problem/layout.h"
#include "mlic_core/problem/state.h"
#include "mlic_core/sensors/pinhole_model.h"

namespace mlic::priors_test {
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

// As far off as a car's vertical focal length comes out, which its little pitch tells.
TEST(CalibrationPrior, DrawsPixelsToSquareFromAfar) {
  const Eigen::Vector2d far = Step(WithFocalLengths(498.0, 479.0), 3.0);
  EXPECT_NEAR(far[1] - far[0], 19.0, 0.5);
}

TEST(CalibrationPrior, LeavesAnamorphicPixelsAlone) {
  EXPECT_EQ(Step(WithFocalLengths(500.0, 540.0), 100.0).norm(), 0.0);
}

TEST(CalibrationPrior, DrawsACentreThatIsNotToldToItsUsualPlace) {
  CalibrationState state = WithFocalLengths(500.0, 500.0);
  state.cameras[0].intrinsics.width = 641;
  state.cameras[0].intrinsics.height = 481;
  const Layout layout(state, false);
  JointProblem problem;
  problem.cameras.resize(1);
  problem.cameras[0].fixed.usual_centre = true;
  const int at = layout.Intrinsics(0) + 2;
  const auto step = [&](const Eigen::Vector2d& centre) {
    state.cameras[0].intrinsics.parameters[2] = centre.x();
    state.cameras[0].intrinsics.parameters[3] = centre.y();
    Eigen::MatrixXd information;
    Eigen::VectorXd gradient;
    CalibrationPrior(problem, state, layout, &information, &gradient);
    EXPECT_NEAR(information(at, at), 1.0 / (0.015 * 641 * 0.015 * 641), 1e-9);
    return Eigen::Vector2d(-information.block<2, 2>(at, at).ldlt().solve(gradient.segment<2>(at)));
  };
  EXPECT_NEAR((step({325.0, 205.0}) - Eigen::Vector2d(-5.0, 35.0)).norm(), 0.0, 1e-9);
  problem.cameras[0].given_intrinsics = {{500.0, 500.0, 300.0, 210.0, 0.0, 0.0, 0.0, 0.0, 0.0}};
  EXPECT_NEAR((step({325.0, 205.0}) - Eigen::Vector2d(-25.0, 5.0)).norm(), 0.0, 1e-9);
}

// A solve whose data have a lens fold over at the outermost of what it sees comes to rest before.
TEST(CalibrationPrior, KeepsARationalLensFromFoldingOver) {
  CalibrationState state = WithFocalLengths(500.0, 500.0);
  state.cameras[0].intrinsics.model = CameraModel::kRationalPolynomial;
  std::vector<double>& lens = state.cameras[0].intrinsics.parameters;
  lens.resize(12, 0.0);
  lens[4] = -0.29;
  state.cameras[0].intrinsics.width = 641;
  state.cameras[0].intrinsics.height = 481;
  JointProblem problem;
  problem.cameras.resize(1);
  problem.drives.resize(1);
  LandmarkObservation seen{};
  seen.pixel = {320.0 + 351.0, 240.0};
  problem.drives[0].landmarks.observations = {seen};
  const Layout layout(state, false);
  const int k1 = layout.Intrinsics(0) + 4;
  // Data that ask for k1 = -0.32, which folds at 341 px, to 0.05.
  constexpr double kWeight = 1.0 / (0.05 * 0.05);
  for (int i = 0; i < 30; ++i) {
    Eigen::MatrixXd information;
    Eigen::VectorXd gradient;
    CalibrationPrior(problem, state, layout, &information, &gradient);
    lens[4] -= 0.5 * (gradient[k1] + kWeight * (lens[4] + 0.32)) / (information(k1, k1) + kWeight);
    ASSERT_TRUE(PinholeMagnification(lens.data(), true, 351.0)) << i;
  }
  EXPECT_GT(lens[4], -0.31);
}

}  // namespace
}  // namespace mlic::priors_test
