#include "mlic_core/sensors/lens_reach.h"

#include <gtest/gtest.h>

namespace mlic::lens_reach_test {
namespace {

TEST(LensReach, IsWholeWhereTheModelHoldsForAllOfTheImage) {
  EXPECT_EQ(ReachOfLens(
                {CameraModel::kRationalPolynomial,
                 800,
                 600,
                 {366.1, 366.6, 398.0, 306.9, 0.8127, 0.0918, 1e-4, -2e-4, 0.0021, 1.0871, 0.3127, 0.0068}}),
            1.0);
}

// Found where no landmark was seen in the corners: right to 0.1 px up to 430 px from the middle, 500 px being
// the corners, with a root of the denominator at 450 px that one of the numerator nearly cancels.
TEST(LensReach, EndsAtAPole) {
  const double reach = ReachOfLens({CameraModel::kRationalPolynomial,
                                    800,
                                    600,
                                    {366.10372, 366.54434, 398.14983, 307.00424, 0.50516, -0.02484, 1e-4,
                                     -2e-4, -0.00853, 0.78033, 0.10949, -0.03195}});
  EXPECT_GT(reach, 0.8);
  EXPECT_LT(reach, 0.95);
}

TEST(LensReach, EndsAtTheCircleOfAFisheye) {
  const double reach =
      ReachOfLens({CameraModel::kEquidistant, 800, 800, {127.0, 127.0, 399.5, 399.5, 0.0, 0.0, 0.0, 0.0}});
  EXPECT_NEAR(reach, 127.0 * M_PI / (399.5 * M_SQRT2), 0.02);
}

}  // namespace
}  // namespace mlic::lens_reach_test
