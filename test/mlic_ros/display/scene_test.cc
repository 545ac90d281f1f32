#include "mlic_ros/display/scene.h"

#include <gtest/gtest.h>

namespace mlic::scene_test {
namespace {

MapPoint Point(float z, int lidar, int plane) {
  MapPoint point;
  point.position = Eigen::Vector3f(0.0f, 0.0f, z);
  point.lidar = lidar, point.plane = plane;
  return point;
}

Scene TwoLidars() {
  Scene scene;
  scene.lidars = {"front", "rear"};
  scene.points = {Point(0.0f, 0, 0), Point(0.1f, 1, 0), Point(-0.1f, 1, 0), Point(0.0f, 1, -1)};
  const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
  scene.planes = {{zero, Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY()}};
  scene.sensors.resize(3);
  scene.sensors[0].name = "front", scene.sensors[1].name = "rear", scene.sensors[2].name = "cam";
  scene.sensors[2].frame_id = "cam_optical";
  scene.sensors[1].state = SensorStatus::ESTIMATED;
  scene.sensors[1].has_guess = true;
  scene.sensors[1].guess.translation.x = -1.0;
  scene.frustums.markers.resize(1);
  scene.frustums.markers[0].header.frame_id = "cam_optical";
  return scene;
}

RoundHistory Rounds(int count) {
  RoundHistory history;
  for (int k = 0; k < count; ++k) history.Add(TwoLidars());
  return history;
}

TEST(Scene, ColoursTellLidarsSidesOfAPlaneAndPlanesApart) {
  const Scene scene = TwoLidars();
  const auto by_sensor = ColoursOf(scene, Colouring::kSensor);
  EXPECT_NE(by_sensor[0], by_sensor[1]);
  EXPECT_EQ(by_sensor[1], by_sensor[2]);
  const auto by_residual = ColoursOf(scene, Colouring::kResidual);
  EXPECT_EQ(by_residual[1], 0xff0000u);
  EXPECT_EQ(by_residual[2], 0x0000ffu);
  EXPECT_EQ(by_residual[0], by_residual[3]);
  const auto by_plane = ColoursOf(scene, Colouring::kPlane);
  EXPECT_EQ(by_plane[0], by_plane[1]);
  EXPECT_NE(by_plane[0], by_plane[3]);
  EXPECT_EQ(PlaneColours(scene, Colouring::kPlane), (std::vector<std::uint32_t>{by_plane[0]}));
  const std::uint32_t of_no_lidar = PlaneColours(scene, Colouring::kSensor).at(0);
  EXPECT_NE(of_no_lidar, by_sensor[0]);
  EXPECT_NE(of_no_lidar, by_sensor[1]);
}

TEST(Scene, PlanesWithMoreScatterThanMostStandOut) {
  Scene scene;
  const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
  for (int plane = 0; plane < 4; ++plane) {
    scene.planes.push_back(
        {zero, Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY()});
    for (const float side : {-1.0f, 1.0f})
      scene.points.push_back(Point(side * (plane < 3 ? 0.02f : 0.07f), 0, plane));
  }
  const auto colours = PlaneColours(scene, Colouring::kResidual);
  for (int plane = 0; plane < 3; ++plane) EXPECT_EQ(colours[static_cast<std::size_t>(plane)], 0xebebffu);
  EXPECT_EQ(colours[3], 0xff0000u);
}

TEST(Scene, PlanesOfOthersGiveNoResiduals) {
  Scene scene = TwoLidars();
  scene.planes_of_points = false;
  EXPECT_EQ(ColoursOf(scene, Colouring::kResidual)[1], ColoursOf(scene, Colouring::kResidual)[0]);
  for (const Colouring colouring : {Colouring::kResidual, Colouring::kPlane}) {
    EXPECT_EQ(PlaneColours(scene, colouring), PlaneColours(scene, Colouring::kSensor));
  }
}

TEST(Scene, LegendHasOneColourForEachWord) {
  for (const char* word : {"sensor", "residual", "plane"}) {
    Status status;
    SetLegend(ColouringOf(word).value(), TwoLidars(), &status);
    EXPECT_FALSE(status.legend.empty());
    EXPECT_EQ(status.legend.size(), status.legend_colours.size());
  }
  EXPECT_FALSE(ColouringOf("speed").has_value());
  Scene scene = TwoLidars();
  scene.landmarks.resize(1);
  scene.trajectory.resize(1);
  scene.turning = TurningAlong(scene.trajectory);
  Status status;
  SetLegend(Colouring::kSensor, scene, &status);
  EXPECT_EQ(status.legend,
            (std::vector<std::string>{"front", "rear", "landmarks on their pixels", "off by 3 px or more",
                                      "path without a turn", "turning by 5 deg/s"}));
  EXPECT_EQ(status.legend_colours.size(), status.legend.size());
}

TEST(Scene, HiddenSensorsHaveNeitherPointsNorFrustum) {
  const Scene visible = WithoutHidden(TwoLidars(), {"rear", "cam"});
  ASSERT_EQ(visible.points.size(), 1u);
  EXPECT_EQ(visible.points[0].lidar, 0);
  EXPECT_EQ(visible.frustums.markers[0].action, visualization_msgs::Marker::DELETE);
  const Scene all = WithoutHidden(TwoLidars(), {});
  EXPECT_EQ(all.points.size(), 4u);
  EXPECT_EQ(all.frustums.markers[0].action, visualization_msgs::Marker::ADD);
}

TEST(Scene, SensorsWithoutAGuessStayWhereTheyAre) {
  Scene scene = TwoLidars();
  scene.sensors[0].state = SensorStatus::ESTIMATED;
  scene.sensors[0].transform.translation.x = 3.0;
  Scene first = TwoLidars();
  first.points.resize(1);
  first.sensors.clear();
  const Scene before = WithGuesses(scene, first);
  EXPECT_EQ(before.points.size(), 1u);
  EXPECT_EQ(before.sensors[0].transform.translation.x, 3.0);
  EXPECT_EQ(before.sensors[1].transform.translation.x, -1.0);
}

TEST(RoundHistory, IsBoundedAndKeepsTheFirstAndTheLastRound) {
  constexpr int kMany = 200;
  RoundHistory history;
  Scene large = TwoLidars();
  large.points.resize(3 * RoundHistory::kMostPoints);
  history.Add(large);
  EXPECT_LE(history.Scenes()[0].points.size(), RoundHistory::kMostPoints);
  for (int k = 1; k < kMany; ++k) {
    history.Add(TwoLidars());
    EXPECT_LE(history.Scenes().size(), RoundHistory::kMostRounds);
    EXPECT_EQ(history.Scenes().front().round, 1);
    EXPECT_EQ(history.Scenes().back().round, k + 1);
  }
  EXPECT_EQ(history.RoundCount(), kMany);
}

TEST(RoundHistory, TheFirstMapToCompareWithHasAllLidars) {
  RoundHistory history;
  Scene front = TwoLidars();
  front.points.resize(1);
  history.Add(front);
  history.Add(TwoLidars());
  history.Add(TwoLidars());
  EXPECT_EQ(history.FirstOfAllLidars().round, 2);
}

TEST(RoundHistory, StepsBackAndForth) {
  const RoundHistory history = Rounds(4);
  EXPECT_EQ(history.Find("previous", 0)->round, 4);
  EXPECT_EQ(history.Find("previous", 4)->round, 3);
  EXPECT_EQ(history.Find("previous", 1)->round, 1);
  EXPECT_EQ(history.Find("next", 3)->round, 4);
  EXPECT_EQ(history.Find("next", 4), nullptr);
  EXPECT_EQ(history.Find("first", 0)->round, 1);
  EXPECT_EQ(history.Find("latest", 2), nullptr);
  EXPECT_EQ(history.Find("2", 0)->round, 2);
  EXPECT_EQ(history.Find("77", 0)->round, 4);
  EXPECT_EQ(RoundHistory().Find("first", 0), nullptr);
}

TEST(RoundHistory, FindsTheNearestKeptRoundOfAThinnedOutOne) {
  const RoundHistory history = Rounds(40);
  EXPECT_EQ(history.At(2), nullptr);
  EXPECT_EQ(history.Find("2", 0)->round, 1);
  EXPECT_EQ(history.Find("next", 1)->round, 3);
}

}  // namespace
}  // namespace mlic::scene_test
