// Places of the map that a LiDAR measured and a camera found again: what they add to the joint problem.
#include "mlic_core/association/map_matches.h"

#include <gtest/gtest.h>

#include <set>
#include <tuple>

#include "mlic_core/association/held_out_matches.h"
#include "mlic_core/problem/joint_problem.h"
#include "mlic_core/problem/joint_solver.h"
#include "mlic_core/problem/state.h"
#include "support/synthetic_tracks.h"
#include "support/true_spline.h"

namespace mlic::map_matches_test {
namespace {

constexpr double kDegree = M_PI / 180.0;

struct Case {
  CalibrationState truth;
  JointProblem problem;
};

// Points that one LiDAR measured and one camera sees up to a second later, without noise.
Case MakeCase() {
  Case c;
  const double duration = 8.0;
  const auto trajectory = sim::MakeTrajectory(sim::Scenario::kHandheld, 3, duration, RigidTransform());
  DriveState drive;
  drive.trajectory = TrueSpline(*trajectory, duration, kSyntheticKnots);
  c.truth.drives.push_back(drive);
  c.truth.lidars.push_back(
      {{FromRollPitchYaw(kDegree * Eigen::Vector3d(3.0, -17.0, 128.0)), {0.08, -0.05, 0.12}}, 0.05});
  CameraCalibration camera;
  camera.sensor = {{FromRollPitchYaw(kDegree * Eigen::Vector3d(-91.0, 1.0, -89.0)), {0.06, 0.11, -0.01}},
                   -0.02};
  camera.intrinsics = {
      CameraModel::kPlumbBob, 752, 480, {392.0, 391.0, 371.0, 244.0, -0.09, 0.018, 0.0004, -0.0006, -0.001}};
  camera.rolling_shutter = true;
  camera.readout = 0.02;
  c.truth.cameras.push_back(camera);
  Random random(1);
  LandmarkSet set;
  set.begin.push_back(0);
  while (set.points.size() < 600) {
    const double stamp = random.Uniform(0.3, duration - 0.3);
    const RigidTransform T_map_camera = drive.trajectory.Pose(stamp) * camera.sensor.T_imu_sensor;
    const double depth = random.Uniform(2.0, 15.0);
    const Eigen::Vector3d point = T_map_camera * Eigen::Vector3d(depth * random.Uniform(-0.9, 0.9),
                                                                 depth * random.Uniform(-0.6, 0.6), depth);
    Eigen::Vector2d pixel;
    if (!See(drive.trajectory, camera, stamp, point, &pixel)) continue;
    LidarPointObservation observation;
    observation.lidar = 0;
    observation.time = std::clamp(stamp + random.Uniform(-1.0, 1.0), 0.0, duration - 0.2);
    observation.position =
        (drive.trajectory.Pose(observation.time + 0.05) * c.truth.lidars[0].T_imu_sensor).Inverse() * point;
    observation.sigma_along = 0.01f;
    observation.sigma_across = 0.003f;
    Eigen::Matrix2f shape;
    shape << 1.0f, 0.3f, 0.0f, 0.8f;
    set.points.push_back({point, T_map_camera.translation});
    set.lidar_points.push_back(observation);
    set.observations.push_back({0, 0.5f, stamp, pixel, shape});
    set.begin.push_back(set.observations.size());
  }
  c.problem.drives.resize(1);
  c.problem.drives[0].landmarks = set;
  c.problem.lidars.resize(1);
  c.problem.cameras.resize(1);
  c.problem.fix_trajectory = true;
  return c;
}

double Distance(const SensorCalibration& a, const SensorCalibration& b) {
  return AngleBetween(a.T_imu_sensor.rotation, b.T_imu_sensor.rotation) +
         (a.T_imu_sensor.translation - b.T_imu_sensor.translation).norm() +
         std::abs(a.time_offset - b.time_offset);
}

void Disturb(SensorCalibration* sensor) {
  sensor->T_imu_sensor.rotation =
      ExpQuaternion(Eigen::Vector3d(0.004, -0.006, 0.003)) * sensor->T_imu_sensor.rotation;
  sensor->T_imu_sensor.translation += Eigen::Vector3d(0.01, -0.02, 0.015);
  sensor->time_offset += 0.002;
}

TEST(MapMatches, TieTheCameraToTheLidar) {
  Case c = MakeCase();
  c.problem.lidars[0].fixed = true;
  CalibrationState state = c.truth;
  Disturb(&state.cameras[0].sensor);
  state.cameras[0].intrinsics.parameters[0] += 3.0;
  state.cameras[0].readout += 0.001;
  SolveJointProblem(c.problem, 12, CancellationToken(), &state);
  // The readout has a wide prior, which these few points feel.
  EXPECT_LT(Distance(state.cameras[0].sensor, c.truth.cameras[0].sensor), 1e-6);
  EXPECT_NEAR(state.cameras[0].intrinsics.parameters[0], c.truth.cameras[0].intrinsics.parameters[0], 1e-4);
  EXPECT_NEAR(state.cameras[0].readout, c.truth.cameras[0].readout, 1e-6);
}

TEST(MapMatches, TieTheLidarToTheCamera) {
  Case c = MakeCase();
  c.problem.cameras[0].fixed = {true, true, true, true, std::vector<bool>(9, true)};
  CalibrationState state = c.truth;
  Disturb(&state.lidars[0]);
  SolveJointProblem(c.problem, 12, CancellationToken(), &state);
  EXPECT_LT(Distance(state.lidars[0], c.truth.lidars[0]), 1e-7);
}

TEST(MapMatches, AppendedPointsKeepTheirObservations) {
  Case c = MakeCase();
  LandmarkSet tracks;
  tracks.begin = {0, 2};
  tracks.points.resize(1);
  tracks.observations.resize(2);
  LandmarkSet all = tracks;
  Append(c.problem.drives[0].landmarks, &all);
  ASSERT_EQ(all.points.size(), 601u);
  EXPECT_FALSE(all.IsOnMap(0));
  EXPECT_TRUE(all.IsOnMap(600));
  EXPECT_EQ(all.begin[601], 602u);
  EXPECT_EQ(all.observations[601].pixel, c.problem.drives[0].landmarks.observations[599].pixel);
}

// What matches err by together.
struct SharedErrors {
  double of_part = 0.0;  // share of the error's variance that matches of one part of a photo have in common
  double shift = 0.0;    // px, of a whole photo
  double smear = 0.0;    // s, of a whole photo, along the motion of the image
};

// Photos full of matches that err by 0.5 px.
LandmarkSet PhotosOfMatches(const SharedErrors& shared) {
  Case c = MakeCase();
  const SplitSpline& trajectory = c.truth.drives[0].trajectory;
  const CameraCalibration& camera = c.truth.cameras[0];
  const SensorCalibration& lidar = c.truth.lidars[0];
  LandmarkSet set;
  set.begin.push_back(0);
  Random random(3);
  const auto draw = [&] { return Eigen::Vector2d(random.Normal(), random.Normal()); };
  for (int photo = 0; photo < 40; ++photo) {
    const double stamp = 0.5 + 0.17 * photo;
    const RigidTransform T_map_camera = trajectory.Pose(stamp) * camera.sensor.T_imu_sensor;
    std::vector<Eigen::Vector2d> common(15);
    for (Eigen::Vector2d& of_block : common) of_block = draw();
    const Eigen::Vector2d shift = shared.shift * draw();
    const double late = shared.smear * random.Normal();
    for (int i = 0; i < 120; ++i) {
      const Eigen::Vector3d point = T_map_camera * Eigen::Vector3d(5.0 * random.Uniform(-0.8, 0.8),
                                                                   5.0 * random.Uniform(-0.5, 0.5), 5.0);
      Eigen::Vector2d pixel, later;
      if (!See(trajectory, camera, stamp, point, &pixel)) continue;
      if (!See(trajectory, camera, stamp + late, point, &later)) continue;
      const int block = static_cast<int>(pixel.x() / 160.0) + 5 * static_cast<int>(pixel.y() / 160.0);
      pixel = later + shift +
              0.5 * (std::sqrt(1.0 - shared.of_part) * draw() + std::sqrt(shared.of_part) * common[block]);
      LidarPointObservation observation;
      observation.lidar = 0;
      observation.time = stamp;
      observation.position =
          (trajectory.Pose(stamp + lidar.time_offset) * lidar.T_imu_sensor).Inverse() * point;
      set.points.push_back({point, T_map_camera.translation});
      set.lidar_points.push_back(observation);
      set.observations.push_back({0, 0.5f, stamp, pixel});
      set.begin.push_back(set.observations.size());
    }
  }
  return set;
}

MatchNoise NoiseOfMatches(const SharedErrors& shared, const MatchNoise& made_with = {}) {
  std::vector<DriveTerms> drives(1);
  drives[0].landmarks = PhotosOfMatches(shared);
  WeakenMatches({made_with}, MakeCase().truth, 0, &drives[0].landmarks);
  return MeasureMatchNoise(drives, MakeCase().truth, {made_with})[0];
}

TEST(MapMatches, AboutATenthIsHeldOutByWholePartsOfPhotos) {
  const LandmarkSet all = PhotosOfMatches({});
  LandmarkSet kept = all;
  const LandmarkSet held_out = TakeHeldOutMatches(&kept);
  ASSERT_EQ(kept.points.size() + held_out.points.size(), all.points.size());
  const double share = static_cast<double>(held_out.points.size()) / static_cast<double>(all.points.size());
  EXPECT_GT(share, 0.06);
  EXPECT_LT(share, 0.14);
  const auto parts = [](const LandmarkSet& set) {
    std::set<std::tuple<double, int, int>> parts;
    for (std::size_t p = 0; p < set.points.size(); ++p) {
      EXPECT_TRUE(set.IsOnMap(p));
      const LandmarkObservation& o = set.observations[set.begin[p]];
      parts.insert({o.time, static_cast<int>(o.pixel.x() / 160.0), static_cast<int>(o.pixel.y() / 160.0)});
    }
    return parts;
  };
  const auto of_kept = parts(kept);
  for (const auto& part : parts(held_out)) EXPECT_EQ(of_kept.count(part), 0u);
}

TEST(MapMatches, HeldOutMatchesFollowTheLidarAndTellTheCamerasError) {
  const Case c = MakeCase();
  const std::vector<LandmarkSet> held_out{c.problem.drives[0].landmarks};
  const std::vector<HeldOutMatches> truth = EvaluateHeldOutMatches(held_out, c.truth);
  ASSERT_EQ(truth.size(), 1u);
  EXPECT_EQ(truth[0].count, held_out[0].points.size());
  EXPECT_LT(truth[0].rms, 1e-5);
  // The places follow the LiDAR: when both move together on the vehicle, little but what it turned between
  // scan and photo is left.
  CalibrationState moved = c.truth;
  moved.lidars[0].T_imu_sensor.translation += Eigen::Vector3d(0.01, 0.0, 0.0);
  const double lidar_alone = EvaluateHeldOutMatches(held_out, moved)[0].median;
  moved.cameras[0].sensor.T_imu_sensor.translation += Eigen::Vector3d(0.01, 0.0, 0.0);
  EXPECT_LT(EvaluateHeldOutMatches(held_out, moved)[0].median, 0.7 * lidar_alone);
  // A centre that is off by 3 px shows as 3 px.
  moved = c.truth;
  moved.cameras[0].intrinsics.parameters[2] += 3.0;
  const HeldOutMatches off = EvaluateHeldOutMatches(held_out, moved)[0];
  EXPECT_NEAR(off.median, 3.0, 1e-3);
  EXPECT_NEAR(off.rms, 3.0, 1e-3);
  moved.cameras.emplace_back(c.truth.cameras[0]);
  EXPECT_EQ(EvaluateHeldOutMatches(held_out, moved)[1].count, 0u);
}

TEST(MapMatches, MatchesThatErrTogetherCountForLess) {
  const MatchNoise independent = NoiseOfMatches({});
  EXPECT_NEAR(independent.scale, 1.0, 0.1);
  EXPECT_LT(independent.shift, 0.05);
  EXPECT_LT(independent.smear, 1e-4);
  // Of n matches with correlation 0.5 the mean errs by the square root of 1 + 0.5 (n - 1); some 8 lie in a
  // part.
  const MatchNoise together = NoiseOfMatches({0.5, 0.0, 0.0});
  EXPECT_GT(together.scale, 1.8);
  EXPECT_LT(together.scale, 3.0);
}

TEST(MapMatches, PhotosThatErrAsAWholeAreToldFromTheirParts) {
  const SharedErrors errors{0.0, 0.3, 2e-3};
  const MatchNoise found = NoiseOfMatches(errors);
  EXPECT_NEAR(found.scale, 1.0, 0.1);
  EXPECT_NEAR(found.shift, 0.3, 0.1);
  EXPECT_NEAR(found.smear, 2e-3, 6e-4);
  // The same with sigmas that are as large already.
  const MatchNoise again = NoiseOfMatches(errors, found);
  EXPECT_NEAR(again.scale, found.scale, 0.1);
  EXPECT_NEAR(again.shift, found.shift, 1e-3);
  EXPECT_NEAR(again.smear, found.smear, 1e-5);
}

TEST(MapMatches, WhatTheCameraIsOffByIsNoNoiseOfItsMatches) {
  const Case c = MakeCase();
  std::vector<DriveTerms> drives(1);
  drives[0].landmarks = PhotosOfMatches({0.0, 0.3, 0.0});
  // By 3 to 10 px and more in all photos alike.
  CalibrationState off = c.truth;
  Disturb(&off.cameras[0].sensor);
  off.cameras[0].intrinsics.parameters[0] += 3.0;
  const MatchNoise found = MeasureMatchNoise(drives, off, {{}})[0];
  EXPECT_NEAR(found.scale, 1.0, 0.1);
  EXPECT_NEAR(found.shift, 0.3, 0.1);
  EXPECT_LT(found.smear, 1e-3);
}

TEST(MapMatches, ThePhotosMeanIsAsUnsureAsItsSharedError) {
  LandmarkSet matches = PhotosOfMatches({});
  WeakenMatches({{1.0, 0.3, 0.0}}, MakeCase().truth, 0, &matches);
  double information = 0.0, count = 0.0;
  for (const LandmarkObservation& o : matches.observations) {
    if (o.time != matches.observations[0].time) continue;
    information += std::pow(o.shape(0, 0) / o.sigma, 2);
    count += 1.0;
  }
  EXPECT_NEAR(1.0 / information, 0.5 * 0.5 / count + 0.3 * 0.3, 1e-5);
}

}  // namespace
}  // namespace mlic::map_matches_test
