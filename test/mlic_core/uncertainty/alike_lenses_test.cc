#include "mlic_core/uncertainty/alike_lenses.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mlic_core/sensors/camera_model.h"

namespace mlic::alike_lenses_test {
namespace {

CameraIntrinsics Rational(const std::vector<double>& radial) {
  return {CameraModel::kRationalPolynomial,
          800,
          600,
          {366.1, 366.6, 398.0, 306.9, radial[0], radial[1], 1e-4, -2e-4, radial[2], radial[3], radial[4],
           radial[5]}};
}

// Two lenses that differ by 0.015 px (rms) within 417 px of the centre; the second was found from tracks that
// the first had projected, k1 being claimed to 0.05 and k2 to 0.004.
const CameraIntrinsics kTrue = Rational({0.81270, 0.09180, 0.00210, 1.08710, 0.31270, 0.00680});
const CameraIntrinsics kFound = Rational({0.50516, -0.02484, -0.00853, 0.78033, 0.10949, -0.03195});
constexpr double kReached = 417.0;  // px

TEST(AlikeLenses, ReachFromOneToTheOther) {
  const Eigen::VectorXd spread = SpreadOfAlikeLenses(kFound, kReached);
  for (const int k : {4, 5, 8, 9, 10, 11}) {
    EXPECT_LT(std::abs(kFound.parameters[k] - kTrue.parameters[k]), 2.0 * spread[k]) << k;
    EXPECT_LT(spread[k], 2.0) << k;
  }
  EXPECT_EQ(spread[0], 0.0);
  EXPECT_EQ(spread[6], 0.0);
}

TEST(AlikeLenses, ProjectAlike) {
  const Eigen::VectorXd spread = SpreadOfAlikeLenses(kTrue, kReached);
  ASSERT_GT(spread[9], 0.1);
  // All of the image leaves less.
  EXPECT_LT(SpreadOfAlikeLenses(kTrue, 500.0)[9], spread[9]);
}

TEST(AlikeLenses, AreNoneOfOtherModels) {
  const CameraIntrinsics lens = IntrinsicsFromFieldOfView(CameraModel::kPlumbBob, 800, 600, 90.0);
  EXPECT_TRUE(SpreadOfAlikeLenses(lens, 500.0).isZero(0.0));
}

}  // namespace
}  // namespace mlic::alike_lenses_test
