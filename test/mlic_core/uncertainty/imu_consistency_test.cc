#include "mlic_core/uncertainty/imu_consistency.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mlic_core/common/random.h"
#include "mlic_core/problem/imu_terms.h"
#include "support/true_spline.h"

namespace mlic::imu_consistency_test {
namespace {

constexpr double kDuration = 20.0;
constexpr double kRate = 200.0;
const ImuSigma kSigma{Eigen::Vector3d::Constant(3e-3), Eigen::Vector3d::Constant(3e-2)};

// A spline of knots every 50 ms through a hand-carried walk, and what an IMU with noise measures of it.
struct Case {
  CalibrationState state;
  Dataset dataset;
};

Case MakeCase() {
  Case c;
  const auto walk = sim::MakeTrajectory(sim::Scenario::kHandheld, 5, kDuration, RigidTransform());
  c.state.drives.resize(1);
  c.state.drives[0].trajectory = TrueSpline(*walk, kDuration, 0.05);
  c.dataset.drives.resize(1);
  const double start = c.state.drives[0].trajectory.Start();
  for (int k = 0; start + k / kRate < c.state.drives[0].trajectory.End(); ++k) {
    c.dataset.drives[0].imu.push_back({start + k / kRate, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()});
  }
  const ImuResiduals exact = EvaluateImuResiduals(c.dataset, c.state, 0);
  Random random(3);
  for (std::size_t k = 0; k < exact.values.size(); ++k) {
    ImuSample& sample = c.dataset.drives[0].imu[k];
    for (int a = 0; a < 3; ++a) {
      sample.angular_velocity[a] = exact.values[k][a] + kSigma.gyroscope[a] * random.Normal();
      sample.specific_force[a] = exact.values[k][3 + a] + kSigma.accelerometer[a] * random.Normal();
    }
  }
  return c;
}

TEST(ImuDisagreement, NoiseIsNone) {
  const Case c = MakeCase();
  EXPECT_TRUE(FindImuDisagreements(c.dataset, c.state, {{kSigma}}, 4.0).empty());
}

TEST(ImuDisagreement, FindsTheSecondsInWhichTheTrajectoryWasLost) {
  Case c = MakeCase();
  // From 8 s to 12 s it runs off sideways by half a metre and comes back: up to 0.6 m/s^2.
  PositionSpline& position = c.state.drives[0].trajectory.position;
  const UniformKnots knots = position.knots();
  const double start = c.state.drives[0].trajectory.Start();
  std::vector<Eigen::Vector3d> points = position.control_points();
  for (int j = 0; j < knots.count; ++j) {
    const double t = knots.ControlPointTime(j) - start;
    if (t > 8.0 && t < 12.0) points[j].y() += 0.25 * (1.0 - std::cos(M_PI * (t - 8.0) / 2.0));
  }
  position = PositionSpline(knots, std::move(points));
  const std::vector<ImuDisagreement> all = FindImuDisagreements(c.dataset, c.state, {{kSigma}}, 8.0);
  ASSERT_EQ(all.size(), 1u);
  const ImuDisagreement* const found = &all[0];
  EXPECT_FALSE(found->of_gyroscope);
  EXPECT_EQ(found->drive, 0u);
  EXPECT_NEAR(found->begin, 8.0, 1.0);
  EXPECT_NEAR(found->end, 12.0, 1.0);
  EXPECT_GT(found->mean, 0.2);
  EXPECT_LT(found->mean, 0.7);
  EXPECT_GT(found->ratio, 20.0);
}

}  // namespace
}  // namespace mlic::imu_consistency_test
