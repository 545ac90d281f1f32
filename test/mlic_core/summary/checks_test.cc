#include "mlic_core/summary/checks.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "mlic_core/common/angles.h"
#include "mlic_core/problem/layout.h"
#include "mlic_core/summary/imu_verdict.h"
#include "support/lidars_at_rest.h"

namespace mlic::checks_test {
namespace {

// Two LiDARs, whose rotations about the vertical the data show to these sigmas, deg: of the first to the IMU,
// of the second to the first.
class TwoLidars : public testing::Test {
 protected:
  QualityCheck RotationOfSecond(double of_first, double of_pair) {
    PlaceAtRest(1, 2, &dataset_, &adjustment_.problem, &adjustment_.state);
    adjustment_.contradicted_guesses.assign(2, false);
    adjustment_.rounds.last_change = 0.1;
    rig_.lidars.resize(2);
    rig_.lidars[0].name = "front";
    rig_.lidars[1].name = "rear";
    const int calibration = Layout(adjustment_.state, false).calibration;
    Eigen::MatrixXd information = 1e8 * Eigen::MatrixXd::Identity(calibration, calibration);
    const auto at = [](double sigma) { return std::pow(sigma * kRadiansPerDegree, -2); };
    const int first = Layout::Lidar(0) + 2, second = Layout::Lidar(1) + 2;
    information(first, first) = at(of_first) + at(of_pair);
    information(second, second) = at(of_pair);
    information(first, second) = information(second, first) = -at(of_pair);
    const std::vector<QualityCheck> checks =
        MakeChecks(rig_, dataset_, adjustment_,
                   AnalyzeCalibration(adjustment_.problem, adjustment_.state, information), {true, true}, {});
    return *std::find_if(checks.begin(), checks.end(), [](const QualityCheck& check) {
      return check.name == "excitation_rotation" && check.sensor == "rear";
    });
  }

  Rig rig_;
  Dataset dataset_;
  Adjustment adjustment_;
};

TEST_F(TwoLidars, ShownToTheImuPass) { EXPECT_TRUE(RotationOfSecond(0.3, 0.1).Passed()); }

// A little less than the first, which passes: the rig does not lose it.
TEST_F(TwoLidars, ShownToOneThatPassesAreNotRefused) {
  const QualityCheck check = RotationOfSecond(0.49, 0.2);
  EXPECT_FALSE(check.Passed());
  EXPECT_NEAR(check.value, std::hypot(0.49, 0.2), 1e-3);
  EXPECT_FALSE(check.refuses);
  EXPECT_NE(check.failure.find("against front alone"), std::string::npos) << check.failure;
}

TEST_F(TwoLidars, ShownToNoneAreRefused) {
  EXPECT_TRUE(RotationOfSecond(0.49, 0.6).refuses);  // the pair is not shown
  EXPECT_TRUE(RotationOfSecond(0.6, 0.2).refuses);   // nor the first
}

// A lag that went on to where the motion shows none, and a map that stands on its head.
TEST(ImuState, ThatNoImuHasIsRefused) {
  Adjustment adjustment;
  adjustment.problem.imu.lag_sigma = 0.01;
  adjustment.state.accelerometer_lag = -0.04;
  adjustment.state.drives.resize(1);
  EXPECT_TRUE(CheckImuState(adjustment).Passed());
  adjustment.state.accelerometer_lag = -0.06;
  const QualityCheck lag = CheckImuState(adjustment);
  EXPECT_FALSE(lag.Passed());
  EXPECT_TRUE(lag.refuses);
  EXPECT_NEAR(lag.value, 6.0, 1e-9);
  adjustment.state.drives[0].bias.knots[0][5] = 18.0;
  const QualityCheck bias = CheckImuState(adjustment);
  EXPECT_NE(bias.failure.find("an accelerometer bias of 18 m/s^2"), std::string::npos) << bias.failure;
}

}  // namespace
}  // namespace mlic::checks_test
