#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mlic_core/common/random.h"
#include "mlic_core/problem/joint_solver.h"
#include "mlic_core/problem/landmark_terms.h"
#include "mlic_core/problem/linearizer.h"
#include "mlic_core/problem/partial_problem.h"
#include "mlic_core/problem/plane_terms.h"
#include "support/spline_through.h"
#include "support/test_motion.h"

namespace mlic::clock_drift_test {
namespace {

constexpr double kDuration = 6.0;       // s
constexpr double kLidarDrift = 2e-3;    // s/s
constexpr double kCameraDrift = -3e-3;  // s/s

// A LiDAR and a camera whose clocks drift, swung by hand in a box of 10 m, without noise. Sigmas are so small
// that priors do not count.
class DriftingClocks : public testing::Test {
 protected:
  DriftingClocks() {
    const test::Motion motion = test::HandHeld();
    const UniformKnots knots = UniformKnots::Covering(0.0, kDuration, 0.05);
    DriveState& drive = state_.drives.emplace_back();
    drive.trajectory = SplineThrough(knots, [&](double t) { return motion.T_map_imu(t); });
    const auto placed = [](double rotation, double offset, double drift) {
      return SensorCalibration{
          {FromRollPitchYaw({rotation, -0.2, 0.5}), Eigen::Vector3d(0.1, -0.2, 0.3)}, offset, drift};
    };
    state_.lidars = {placed(0.3, 0.02, kLidarDrift)};
    CameraCalibration& camera = state_.cameras.emplace_back();
    camera.sensor = placed(-1.4, -0.03, kCameraDrift);
    camera.intrinsics.model = CameraModel::kPlumbBob;
    camera.intrinsics.width = 640;
    camera.intrinsics.height = 480;
    camera.intrinsics.parameters = {400.0, 400.0, 320.0, 240.0, -0.1, 0.02, 0.0, 0.0, 0.0};
    camera.rolling_shutter = true;
    camera.readout = 0.02;
    Drive& recorded = dataset_.drives.emplace_back();
    for (double t = 0.0; t < kDuration; t += 0.01) recorded.imu.push_back(motion.Sample(t));
    problem_.dataset = &dataset_;
    problem_.drives.resize(1);
    problem_.drives[0].imu_sigma.usual.gyroscope.setConstant(0.01);
    problem_.drives[0].imu_sigma.usual.accelerometer.setConstant(0.1);
    problem_.lidars.resize(1);
    problem_.cameras.resize(1);
    AddPlanes();
    AddPoints();
  }

  double RandomTime() { return 0.2 + (kDuration - 0.4) * random_.Uniform(); }
  RigidTransform PoseOf(const SensorCalibration& sensor, double time, double after = 0.0) const {
    const SplitSpline& trajectory = state_.drives[0].trajectory;
    return trajectory.Pose(sensor.OnImuClock(time, trajectory.Middle()) + after) * sensor.T_imu_sensor;
  }

  void AddPlanes() {
    constexpr double kWall = 5.0;  // m from the middle of the box
    std::vector<std::vector<PlaneObservation>> seen(6);
    for (int k = 0; k < 1200; ++k) {
      const double time = RandomTime();
      const RigidTransform pose = PoseOf(state_.lidars[0], time);
      const Eigen::Vector3d beam = test::NormalVector(&random_).normalized();
      double range = 1e9;
      std::size_t wall = 0;
      for (int side = 0; side < 6; ++side) {
        const double sign = side % 2 == 0 ? 1.0 : -1.0;
        const double to = (sign * kWall - pose.translation[side / 2]) / beam[side / 2];
        if (to > 0.0 && to < range) range = to, wall = side;
      }
      const Eigen::Vector3d in_lidar = pose.Inverse() * (pose.translation + range * beam).eval();
      seen[wall].push_back({in_lidar.cast<float>(), 1e-4f, 1.0f, 0.0f, 0, 0, time});
    }
    PlaneAssociation& planes = problem_.drives[0].planes;
    planes.begin = {0};
    for (int side = 0; side < 6; ++side) {
      std::sort(seen[side].begin(), seen[side].end(),
                [](const PlaneObservation& a, const PlaneObservation& b) { return a.time < b.time; });
      MapPlane plane;
      plane.plane = {(side % 2 == 0 ? -1.0 : 1.0) * Eigen::Vector3d::Unit(side / 2), -kWall};
      plane.center = -kWall * plane.plane.normal;
      planes.planes.push_back(plane);
      planes.observations.insert(planes.observations.end(), seen[side].begin(), seen[side].end());
      planes.begin.push_back(planes.observations.size());
    }
  }

  // Each second one is a place of the map.
  void AddPoints() {
    LandmarkSet& set = problem_.drives[0].landmarks;
    const CameraCalibration& camera = state_.cameras[0];
    set.begin = {0};
    for (int p = 0; p < 60; ++p) {
      const Eigen::Vector3d point = 4.0 * test::NormalVector(&random_).normalized();
      for (int k = 0; k < 40; ++k) {
        const double time = RandomTime();
        Eigen::Vector2d pixel(320.0, 240.0);
        bool seen = true;
        for (int i = 0; i < 20 && seen; ++i) {  // the row's time hangs on the row
          const Eigen::Vector3d in_camera =
              PoseOf(camera.sensor, time, pixel.y() / 480.0 * camera.readout).Inverse() * point;
          seen = in_camera.z() > 1.0 && in_camera.head<2>().norm() < 0.7 * in_camera.z() &&
                 Project(camera.intrinsics, in_camera, &pixel);
        }
        if (seen) set.observations.push_back({0, 0.01f, time, pixel});
      }
      if (set.observations.size() < set.begin.back() + 2) {
        set.observations.resize(set.begin.back());
        continue;
      }
      set.begin.push_back(set.observations.size());
      set.points.push_back({point, Eigen::Vector3d::Zero()});
      LidarPointObservation& on_map = set.lidar_points.emplace_back();
      if (p % 2 == 0) continue;
      const double time = RandomTime();
      on_map = {0, time, PoseOf(state_.lidars[0], time).Inverse() * point, 2e-4f, 1e-4f};
    }
  }

  Random random_{7};
  Dataset dataset_;
  JointProblem problem_;
  CalibrationState state_;
};

// Without residuals the normal equations are the derivatives of the gradient.
TEST_F(DriftingClocks, StandRightInTheNormalEquations) {
  ASSERT_GT(problem_.drives[0].landmarks.points.size(), 20u);
  const Layout layout(state_, false);
  std::vector<LandmarkCoupling> couplings;
  const Accumulator sum = Linearize({problem_, state_, layout}, &couplings);
  for (const SensorId sensor : {LidarId(0), CameraId(0)}) {
    const int drift = layout.Drift(sensor);
    ASSERT_GE(drift, 0);
    constexpr double kStep = 1e-6;
    const auto at = [&](double step, std::vector<LandmarkCoupling>* moved_couplings) {
      CalibrationState moved = state_;
      Eigen::VectorXd delta = Eigen::VectorXd::Zero(layout.Total());
      delta[layout.knots + drift] = step;
      layout.Update(delta, &moved);
      return Linearize({problem_, moved, layout}, moved_couplings);
    };
    std::vector<LandmarkCoupling> couplings_after, couplings_before;
    const Accumulator after = at(kStep, &couplings_after), before = at(-kStep, &couplings_before);
    const Eigen::VectorXd by_calibration =
        (after.gradient_calibration - before.gradient_calibration) / (2.0 * kStep);
    const Eigen::VectorXd by_knots = (after.gradient_knots - before.gradient_knots) / (2.0 * kStep);
    EXPECT_LT((by_calibration - sum.corner.col(drift)).norm(), 1e-3 * sum.corner.col(drift).norm());
    EXPECT_LT((sum.corner.col(drift) - sum.corner.row(drift).transpose()).norm(),
              1e-12 * sum.corner.col(drift).norm());
    EXPECT_LT((by_knots - sum.border.row(drift).transpose()).norm(), 1e-3 * sum.border.row(drift).norm());
    double difference = 0.0, size = 0.0;
    for (std::size_t k = 0; k < couplings.size(); ++k) {
      const Eigen::Vector3d coupling = couplings[k].calibration.row(drift).transpose();
      difference += ((couplings_after[k].gradient - couplings_before[k].gradient) / (2.0 * kStep) - coupling)
                        .squaredNorm();
      size += coupling.squaredNorm();
    }
    EXPECT_GT(size, 0.0);
    EXPECT_LT(std::sqrt(difference), 1e-3 * std::sqrt(size));
  }
}

TEST_F(DriftingClocks, AreFoundToNumericalPrecision) {
  const CalibrationState truth = state_;
  problem_.fix_trajectory = true;
  state_.lidars[0].clock_drift = state_.cameras[0].sensor.clock_drift = 0.0;
  state_.lidars[0].time_offset += 1e-3;
  const SolveSummary summary = SolveJointProblem(problem_, 40, CancellationToken(), &state_);
  EXPECT_TRUE(summary.solved);
  EXPECT_NEAR(*state_.lidars[0].clock_drift, kLidarDrift, 1e-7);
  EXPECT_NEAR(*state_.cameras[0].sensor.clock_drift, kCameraDrift, 1e-7);
  EXPECT_NEAR(state_.lidars[0].time_offset, truth.lidars[0].time_offset, 1e-7);
  EXPECT_NEAR(state_.cameras[0].sensor.time_offset, truth.cameras[0].sensor.time_offset, 1e-7);
}

TEST_F(DriftingClocks, AreHeldWithTheSensor) {
  problem_.lidars[0].fixed = true;
  problem_.cameras[0].fixed.time_offset = true;
  const Layout layout(state_, false);
  const std::vector<bool> moves = FreeCalibration(problem_, layout);
  EXPECT_FALSE(moves[layout.Drift(LidarId(0))]);
  EXPECT_FALSE(moves[layout.Drift(CameraId(0))]);
}

// A part's middle is another one than the drive's.
TEST_F(DriftingClocks, KeepTheirTimesInAPart) {
  constexpr double kCut = 2.6;  // s
  std::size_t of_planes = 0, of_points = 0, samples = 0;
  for (const TimeInterval& stretch : {TimeInterval{0.0, kCut}, TimeInterval{kCut, kDuration}}) {
    const PartialProblem part(problem_, state_, {stretch});
    const DriveTerms& terms = part.problem.drives[0];
    of_planes += terms.planes.observations.size();
    of_points += terms.landmarks.observations.size();
    samples += part.dataset.drives[0].imu.size();
    const SplitSpline& trajectory = part.state.drives[0].trajectory;
    EXPECT_NEAR(trajectory.Start(), stretch.start, 0.05);
    EXPECT_NEAR(trajectory.End(), stretch.end, 0.05);
    EXPECT_TRUE(trajectory.Contains(stretch.start) && trajectory.Contains(stretch.end));
    for (const float residual : PlaneResiduals(terms.planes, part.state, 0)) {
      EXPECT_LT(std::abs(residual), 1e-5);
    }
    for (const Eigen::Vector2d& residual : LandmarkResiduals(terms.landmarks, part.state, 0)) {
      EXPECT_LT(residual.norm(), 1e-4);
    }
  }
  EXPECT_EQ(of_planes, problem_.drives[0].planes.observations.size());
  EXPECT_EQ(samples, dataset_.drives[0].imu.size());
  EXPECT_GT(of_points, problem_.drives[0].landmarks.observations.size() / 2);
}

TEST(SensorCalibration, TurnsClocksThereAndBack) {
  const SensorCalibration sensor{{}, 0.03, 5e-4};
  EXPECT_NEAR(sensor.OnImuClock(100.0, 50.0), 100.055, 1e-12);
  EXPECT_NEAR(sensor.OnOwnClock(100.055, 50.0), 100.0, 1e-12);
  EXPECT_NEAR((SensorCalibration{{}, 0.03, {}}.OnOwnClock(1.03, 50.0)), 1.0, 1e-12);
}

}  // namespace
}  // namespace mlic::clock_drift_test
