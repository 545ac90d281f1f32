#include "mlic_ros/display/status_board.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mlic_ros/display/rig_markers.h"

namespace mlic::status_board_test {
namespace {

Rig TwoLidars() {
  Rig rig;
  rig.lidars.resize(2);
  rig.lidars[0].name = "front", rig.lidars[1].name = "rear";
  rig.lidars[1].frame_id = "/rear_frame";
  rig.lidars[1].guess.emplace();
  rig.lidars[1].guess->T_imu_sensor.translation.x() = -1.0;
  return rig;
}

CalibrationSnapshot Snapshot() {
  CalibrationSnapshot snapshot;
  snapshot.sensor_names = {"front", "rear"};
  snapshot.sensor_frames = {"front", "rear_frame"};
  snapshot.sensors.resize(2);
  snapshot.sensors[1].T_imu_sensor.translation.x() = -1.2;
  snapshot.sigmas.resize(2);
  snapshot.cost = 100.0;
  for (int k = 0; k < 100; ++k) {
    MapPoint point;
    point.position = Eigen::Vector3f(k == 0 ? 9000.0f : k % 2 == 0 ? 10.0f : -10.0f, 0.0f, 0.0f);
    snapshot.points.push_back(point);
  }
  return snapshot;
}

StatusBoard Started() {
  StatusBoard board;
  board.SetPlan({{"loading", 1.0}, {"joint adjustment", 3.0}});
  board.SetProgress("loading", 0.0, 0.0);
  board.SetRig(TwoLidars());
  board.SetProgress("joint adjustment", 0.0, 2.0);
  return board;
}

TEST(StatusBoard, SensorsOfTheRigWaitWithTheirGuesses) {
  const StatusBoard board = Started();
  ASSERT_EQ(board.Get().sensors.size(), 2u);
  EXPECT_EQ(board.Get().sensors[0].state, SensorStatus::WAITING);
  EXPECT_FALSE(board.Get().sensors[0].has_guess);
  EXPECT_EQ(board.Get().sensors[1].frame_id, "rear_frame");
  EXPECT_EQ(board.Get().sensors[1].guess.translation.x, -1.0);
  EXPECT_EQ(board.Get().stage_number, 2);
  EXPECT_EQ(board.Get().stage_count, 2);
  EXPECT_GT(board.Get().seconds_left, 0.0f);
}

TEST(StatusBoard, EveryRoundAddsToTheCurvesAndKeepsTheGuesses) {
  StatusBoard board = Started();
  CalibrationSnapshot snapshot = Snapshot();
  board.AddSnapshot(snapshot);
  snapshot.change = 0.5;
  snapshot.mean_square = 1.25;
  snapshot.sigmas[1].translation = {0.001, 0.004, 0.002};
  board.AddSnapshot(snapshot);
  const Status& status = board.Get();
  EXPECT_TRUE(std::isnan(status.changes.at(0)));
  EXPECT_EQ(status.changes.at(1), 0.5);
  EXPECT_EQ(status.costs, (std::vector<double>{100.0, 100.0}));
  EXPECT_TRUE(std::isnan(status.mean_squares.at(0)));
  EXPECT_EQ(status.mean_squares.at(1), 1.25);
  EXPECT_EQ(status.largest_sigmas.at(1), 0.004);
  EXPECT_EQ(status.solve_stages, (std::vector<int>{2, 2}));
  EXPECT_EQ(status.sensors.at(1).state, SensorStatus::ESTIMATED);
  EXPECT_EQ(status.sensors.at(1).transform.translation.x, -1.2);
  EXPECT_TRUE(status.sensors.at(1).has_guess);
  EXPECT_LT(status.map_radius, 200.0f) << "one far point decides what is looked at";
}

TEST(StatusBoard, CamerasThatWereFoundAreAllThatChangesWithoutASolve) {
  StatusBoard board = Started();
  CalibrationSnapshot snapshot = Snapshot();
  board.AddSnapshot(snapshot);
  const double sigma = board.Get().sensors.at(0).sigma_translation[0];
  snapshot.after_solve = false;
  snapshot.sigmas.clear();
  snapshot.sensor_names.push_back("camera");
  snapshot.sensor_frames.push_back("camera_frame");
  snapshot.sensors.emplace_back().T_imu_sensor.translation = {0.0, 0.5, 0.0};
  snapshot.intrinsics.emplace_back();
  board.AddSnapshot(snapshot);
  const Status& status = board.Get();
  EXPECT_EQ(status.costs.size(), 1u);
  EXPECT_EQ(status.solve_stages.size(), 1u);
  EXPECT_TRUE(status.sensors.at(0).has_sigma);
  EXPECT_EQ(status.sensors.at(0).sigma_translation[0], sigma);
  ASSERT_EQ(status.sensors.size(), 3u);
  EXPECT_TRUE(status.sensors[2].is_camera);
  EXPECT_EQ(status.sensors[2].state, SensorStatus::ESTIMATED);
  EXPECT_EQ(status.sensors[2].transform.translation.y, 0.5);
}

TEST(StatusBoard, TheFirstViewTakesInTheGuesses) {
  EXPECT_EQ(StatusBoard().Get().map_radius, 0.0f);
  const Status before = Started().Get();
  EXPECT_GT(before.map_radius, 1.0f);
  EXPECT_LT(before.map_radius, 3.0f);
  // By hand: a view of a metre would show the names a few pixels high.
  Rig small = TwoLidars();
  for (LidarConfig& lidar : small.lidars) {
    if (lidar.guess) lidar.guess->T_imu_sensor.translation = Eigen::Vector3d(0.05, 0.0, 0.02);
  }
  StatusBoard by_hand;
  by_hand.SetRig(small);
  EXPECT_GT(by_hand.Get().map_radius, 0.1f);
  EXPECT_LT(by_hand.Get().map_radius, 0.3f);
}

TEST(StatusBoard, TheResultSaysWhatBecameOfEachSensor) {
  StatusBoard board = Started();
  board.AddSnapshot(Snapshot());
  CalibrationResult result;
  result.verdict = Verdict::kPartial;
  result.reasons = {"rear: it moved"};
  result.sensors.resize(1);
  result.sensors[0].name = result.sensors[0].frame_id = "front";
  result.rejected = {{"rear", SensorResult::Type::kLidar, "rear: it moved", {}}};
  board.SetResult(result);
  const Status& status = board.Get();
  EXPECT_EQ(status.state, Status::PARTIAL);
  EXPECT_EQ(status.run_progress, 1.0f);
  EXPECT_EQ(status.sensors.at(0).state, SensorStatus::TRUSTED);
  EXPECT_EQ(status.sensors.at(1).state, SensorStatus::REJECTED);
  EXPECT_EQ(status.sensors.at(1).reason, "rear: it moved");
  board.Tick(1000.0);
  EXPECT_EQ(board.Get().seconds_left, 0.0f);
}

TEST(StatusBoard, NothingIsTrustedOfWhatIsRefused) {
  StatusBoard board = Started();
  CalibrationResult result;
  result.sensors.resize(1);
  result.sensors[0].name = "front";
  board.SetResult(result);
  EXPECT_EQ(board.Get().state, Status::REFUSED);
  EXPECT_EQ(board.Get().sensors.at(0).state, SensorStatus::ESTIMATED);
}

TEST(RigMarkers, GuessesAreThereBeforeTheFirstRound) {
  const visualization_msgs::MarkerArray array = MakeRigMarkers(Started().Get(), "imu");
  ASSERT_EQ(array.markers.size(), 5u) << "none of before; two names, axes, guesses";
  EXPECT_EQ(array.markers[1].text, "IMU");
  EXPECT_EQ(array.markers[2].text, "rear") << "front has neither pose nor guess";
  EXPECT_LT(array.markers[2].color.r, array.markers[1].color.r);
  EXPECT_LT(array.markers[2].pose.position.x, -1.0);
  EXPECT_EQ(array.markers[3].points.size(), 2u * 3u) << "the IMU's";
  EXPECT_EQ(array.markers[4].points.size(), 2u * 3u) << "there is no way from a guess to itself";
}

TEST(RigMarkers, NamesOfWhatIsFoundAndAGreyGuess) {
  StatusBoard board = Started();
  board.AddSnapshot(Snapshot());
  const visualization_msgs::MarkerArray array = MakeRigMarkers(board.Get(), "imu");
  std::vector<std::string> names;
  for (const visualization_msgs::Marker& marker : array.markers) {
    EXPECT_EQ(marker.header.frame_id, "imu");
    if (!marker.text.empty()) names.push_back(marker.text);
  }
  EXPECT_EQ(names, (std::vector<std::string>{"IMU", "front", "rear"}));
  const visualization_msgs::Marker& guesses = array.markers.back();
  ASSERT_EQ(guesses.ns, "guesses");
  EXPECT_EQ(guesses.points.size(), 2u * 4u) << "three axes and the way from there";
  for (const std_msgs::ColorRGBA& colour : guesses.colors) EXPECT_EQ(colour.r, colour.b);
}

TEST(RigMarkers, NamesOfSensorsInOnePlaceStandAboveOneAnother) {
  Status status;
  status.sensors.resize(3);
  for (SensorStatus& sensor : status.sensors) {
    sensor.state = SensorStatus::ESTIMATED;
    sensor.transform.translation.x = 2.0;
    sensor.transform.rotation.w = 1.0;
  }
  std::vector<visualization_msgs::Marker> names;
  for (const visualization_msgs::Marker& marker : MakeRigMarkers(status, "imu").markers) {
    if (marker.ns == "names") names.push_back(marker);
  }
  ASSERT_EQ(names.size(), 4u) << "the IMU's too";
  for (std::size_t k = 2; k < names.size(); ++k) {
    EXPECT_GT(names[k].pose.position.z - names[k - 1].pose.position.z, names[k].scale.z);
    EXPECT_EQ(names[k].pose.position.x, names[k - 1].pose.position.x);
  }
}

TEST(RigMarkers, NamesBehindOneAnotherInTheFirstViewAreApartToo) {
  // From 40 deg above the horizon; from the side or from above they are a metre apart.
  const Eigen::Vector3d from(std::cos(4.0) * std::cos(0.75), std::sin(4.0) * std::cos(0.75), std::sin(0.75));
  const Eigen::Vector3d up(-std::cos(4.0) * std::sin(0.75), -std::sin(4.0) * std::sin(0.75), std::cos(0.75));
  Status status;
  status.sensors.resize(2);
  for (std::size_t k = 0; k < 2; ++k) {
    const Eigen::Vector3d place = Eigen::Vector3d(0.5, 1.0, 0.2) + 1.6 * static_cast<double>(k) * from;
    geometry_msgs::Transform& transform = status.sensors[k].transform;
    transform.translation.x = place.x(), transform.translation.y = place.y(),
    transform.translation.z = place.z();
    transform.rotation.w = 1.0;
    status.sensors[k].state = SensorStatus::ESTIMATED;
  }
  std::vector<double> heights;
  double text = 0.0;
  for (const visualization_msgs::Marker& marker : MakeRigMarkers(status, "imu").markers) {
    if (marker.ns != "names") continue;
    const geometry_msgs::Point& p = marker.pose.position;
    heights.push_back(up.dot(Eigen::Vector3d(p.x, p.y, p.z)));
    text = marker.scale.z;
  }
  ASSERT_EQ(heights.size(), 3u) << "the IMU's too";
  EXPECT_GT(std::abs(heights[2] - heights[1]), text);
}

TEST(RigMarkers, TheOverlaySaysStageThenVerdict) {
  StatusBoard board = Started();
  EXPECT_EQ(MakeOverlay(board.Get()).markers.at(0).text.find("stage 2 of 2\njoint adjustment\n"), 0u);
  Status paused = board.Get();
  paused.paused = true;
  EXPECT_EQ(MakeOverlay(paused).markers.at(0).text, "PAUSED\nstage 2 of 2: joint adjustment");
  board.SetEnd(Status::INTERRUPTED, "INTERRUPTED: by the user");
  EXPECT_EQ(MakeOverlay(board.Get()).markers.at(0).text, "INTERRUPTED");
}

}  // namespace
}  // namespace mlic::status_board_test
