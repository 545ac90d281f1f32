#include "mlic_sim/trajectory.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "mlic_core/common/error.h"
#include "mlic_core/geometry/so3.h"

namespace mlic::sim::trajectory_test {
namespace {

constexpr Scenario kAll[] = {Scenario::kFigureEight, Scenario::kHandheld, Scenario::kTiltedHandheld,
                             Scenario::kStraight,    Scenario::kStatic,   Scenario::kPlanar,
                             Scenario::kCircle,      Scenario::kWeaving};

RigidTransform OddMount() { return {FromRollPitchYaw({0.3, -0.2, 1.1}), Eigen::Vector3d(0.4, -0.3, 1.2)}; }

// Central difference of fourth order.
template <typename Function>
auto Derivative(const Function& f, double t) {
  constexpr double h = 2e-3;
  return ((8.0 * (f(t + h) - f(t - h)) - (f(t + 2 * h) - f(t - 2 * h))) / (12.0 * h)).eval();
}

TEST(Trajectory, DerivativesAgreeWithNumericOnesInEveryScenario) {
  for (Scenario scenario : kAll) {
    for (std::uint64_t seed : {1, 2}) {
      SCOPED_TRACE(ScenarioName(scenario));
      const auto trajectory = MakeTrajectory(scenario, seed, 60.0, OddMount());
      for (double t = 0.3; t < 60.0; t += 3.7) {
        const MotionState state = trajectory->StateAt(t);
        const auto position = [&](double s) { return trajectory->PoseAt(s).translation; };
        const auto velocity = [&](double s) { return trajectory->StateAt(s).velocity; };
        const auto rotation = [&](double s) {
          return Log(
              Eigen::Quaterniond(state.T_map_imu.rotation.conjugate() * trajectory->PoseAt(s).rotation));
        };
        EXPECT_LT((Derivative(position, t) - state.velocity).norm(), 1e-8);
        EXPECT_LT((Derivative(velocity, t) - state.acceleration).norm(), 1e-8);
        EXPECT_LT((Derivative(rotation, t) - state.angular_velocity).norm(), 1e-8);
      }
    }
  }
}

TEST(Trajectory, SeedsGiveDifferentDrives) {
  for (Scenario scenario : {Scenario::kFigureEight, Scenario::kHandheld, Scenario::kCircle}) {
    const auto a = MakeTrajectory(scenario, 1, 60.0, {}), b = MakeTrajectory(scenario, 2, 60.0, {}),
               c = MakeTrajectory(scenario, 1, 60.0, {});
    EXPECT_GT((a->PoseAt(5.0).translation - b->PoseAt(5.0).translation).norm(), 0.01);
    EXPECT_EQ(a->PoseAt(5.0).translation, c->PoseAt(5.0).translation);
  }
}

TEST(Trajectory, FigureEightDrivesAsACarDoes) {
  const auto car = MakeTrajectory(Scenario::kFigureEight, 3, 60.0, {});
  double fastest_turn = 0.0, largest_tilt = 0.0, slowest = 1e9, fastest = 0.0;
  for (double t = 0.0; t < 60.0; t += 0.02) {
    const MotionState state = car->StateAt(t);
    fastest_turn = std::max(fastest_turn, std::abs(state.angular_velocity.z()));
    slowest = std::min(slowest, state.velocity.norm());
    fastest = std::max(fastest, state.velocity.norm());
    const Eigen::Matrix3d R = state.T_map_imu.rotation.toRotationMatrix();
    largest_tilt = std::max(largest_tilt, std::acos(std::min(1.0, R(2, 2))) * 180.0 / M_PI);
    // It goes where it points.
    EXPECT_GT(R.col(0).dot(state.velocity.normalized()), 0.999);
    EXPECT_LT(std::abs(state.T_map_imu.translation.x()), 25.0);
    EXPECT_LT(std::abs(state.T_map_imu.translation.y()), 10.0);
  }
  EXPECT_GT(fastest_turn, 0.42);
  EXPECT_LT(fastest_turn, 0.7);
  EXPECT_GT(slowest, 3.0);
  EXPECT_LT(fastest, 7.0);
  EXPECT_GT(largest_tilt, 0.2);
  EXPECT_LT(largest_tilt, 1.2);
}

TEST(Trajectory, PlanarDriveHasNoTiltAndNoHeave) {
  const auto car = MakeTrajectory(Scenario::kPlanar, 4, 60.0, {Eigen::Quaterniond::Identity(), {0, 0, 1.0}});
  for (double t = 0.0; t < 60.0; t += 0.31) {
    const MotionState state = car->StateAt(t);
    EXPECT_EQ(state.velocity.z(), 0.0);
    EXPECT_EQ(state.acceleration.z(), 0.0);
    EXPECT_EQ(state.T_map_imu.translation.z(), 1.0);
    EXPECT_LT(state.angular_velocity.head<2>().norm(), 1e-15);
  }
}

TEST(Trajectory, HandheldTurnsAboutAllAxesAndStaysInTheFreeMiddle) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto walk = MakeTrajectory(Scenario::kHandheld, seed, 60.0, {});
    Eigen::Vector3d square = Eigen::Vector3d::Zero();
    int count = 0;
    for (double t = 0.0; t < 60.0; t += 0.05, ++count) {
      const MotionState state = walk->StateAt(t);
      square += state.angular_velocity.cwiseAbs2();
      EXPECT_LT(std::abs(state.T_map_imu.translation.x()), 7.5);
      EXPECT_LT(std::abs(state.T_map_imu.translation.y()), 4.0);
      EXPECT_GT(state.T_map_imu.translation.z(), 0.9);
    }
    EXPECT_GT((square / count).cwiseSqrt().minCoeff(), 0.25);
  }
}

TEST(Trajectory, TiltedWalkShowsGravityToAllAxesOfTheAccelerometer) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto walk = MakeTrajectory(Scenario::kTiltedHandheld, seed, 60.0, {});
    std::vector<double> vertical;
    for (double t = 0.0; t < 60.0; t += 0.05) {
      const MotionState state = walk->StateAt(t);
      const Eigen::Vector3d force =
          state.T_map_imu.rotation.conjugate() * (state.acceleration + Eigen::Vector3d(0.0, 0.0, 9.81));
      vertical.push_back(force.z());
      EXPECT_LT(std::acos(state.T_map_imu.rotation.toRotationMatrix()(2, 2)) * 180.0 / M_PI, 85.0);
    }
    const Eigen::Map<Eigen::VectorXd> z(vertical.data(), static_cast<Eigen::Index>(vertical.size()));
    EXPECT_GT(std::sqrt((z.array() - z.mean()).square().mean()), 1.2);  // m/s^2; without tilts about 0.85
  }
}

TEST(Trajectory, StraightAndCircleAreUniform) {
  const auto straight = MakeTrajectory(Scenario::kStraight, 1, 60.0, {});
  EXPECT_EQ(straight->StateAt(3.0).acceleration.norm(), 0.0);
  EXPECT_EQ(straight->StateAt(3.0).velocity, straight->StateAt(50.0).velocity);
  EXPECT_GT(straight->StateAt(3.0).velocity.norm(), 0.5);
  const auto circle = MakeTrajectory(Scenario::kCircle, 1, 60.0, {});
  EXPECT_NEAR(circle->StateAt(3.0).angular_velocity.z(), circle->StateAt(50.0).angular_velocity.z(), 1e-12);
  EXPECT_NEAR(circle->StateAt(3.0).velocity.norm(), circle->StateAt(50.0).velocity.norm(), 1e-12);
}

TEST(Trajectory, WeavingStaysInItsLaneAndHeadsWhereItGoes) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const auto car = MakeTrajectory(Scenario::kWeaving, seed, 15.0, {});
    double left = -100.0, right = 100.0;
    for (double t = 0.0; t < 15.0; t += 0.1) {
      const MotionState state = car->StateAt(t);
      left = std::max(left, state.T_map_imu.translation.y());
      right = std::min(right, state.T_map_imu.translation.y());
      const Eigen::Vector3d own = state.T_map_imu.rotation.conjugate() * state.velocity;
      EXPECT_NEAR(own.y(), 0.0, 1e-9);
      EXPECT_GT(own.x(), 2.0);
    }
    EXPECT_LT(left - right, 2.01);
    EXPECT_GT(left - right, 0.59);
  }
}

TEST(Trajectory, UnknownScenarioIsAnInputError) {
  EXPECT_EQ(ScenarioFromName("handheld"), Scenario::kHandheld);
  EXPECT_THROW(ScenarioFromName("figure_nine"), InputError);
}

}  // namespace
}  // namespace mlic::sim::trajectory_test
