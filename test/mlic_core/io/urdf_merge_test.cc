#include "mlic_core/io/result/urdf_merge.h"

#include <cmath>
#include <cstdlib>
#include <sstream>

#include "mlic_core/geometry/so3.h"
#include "mlic_core/io/result/model_calibration.h"
#include "mlic_core/io/result/sensor_tree.h"
#include "mlic_core/io/text_file.h"
#include "support/files.h"
#include "support/sample_result.h"

namespace mlic::urdf_merge_test {
namespace {

// A robot that has the IMU, one LiDAR on a mast, and the camera on that LiDAR, at other places than the
// calibration; two LiDARs are not in it.
constexpr const char* kRobot = R"(<?xml version="1.0"?>
<!-- Our robot. -->
<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="car">
  <xacro:property name="height" value="0.4"/>

  <link name="ground"/>
  <joint name="base_joint" type="fixed">
    <parent link="ground"/>
    <child link="base_link"/>
    <origin xyz="0 0 ${height}"/>
  </joint>
  <link name="base_link"/>
  <link name="mast"/>  <!-- of steel -->
  <joint name="mast_joint" type="fixed">
    <origin xyz="0.1 0.2 1.5" rpy="0 0 0.5"/>
    <parent link="base_link"/><child link="mast"/>
  </joint>
  <link name="imu_link"/>
  <joint name="imu_joint" type="fixed">
    <origin xyz="0.3 0 0.2" rpy="0.1 0.2 0.3"/>
    <parent link="base_link"/>
    <child link="imu_link"/>
  </joint>
  <link name="front_lidar_link"><visual><geometry><sphere radius="0.1"/></geometry></visual></link>
  <joint name="front_lidar_mount" type="fixed">
    <parent link="mast"/>
    <child link="front_lidar_link"/>
    <origin xyz="9 9 9" rpy="1 1 1"/>
  </joint>
  <link name="bracket"/>
  <joint name="bracket_joint" type="fixed">
    <parent link="front_lidar_link"/>
    <child link="bracket"/>
    <origin xyz="0 0.1 0" rpy="0 0.4 0"/>
  </joint>
  <link name="cam_front_link"/>
  <joint name="cam_joint" type="fixed">
    <parent link="bracket"/>
    <child link="cam_front_link"/>
  </joint>
  <link name="wheel"/>
  <joint name="wheel_joint" type="continuous">
    <parent link="base_link"/>
    <child link="wheel"/>
  </joint>
</robot>
)";

class UrdfMerge : public ::testing::Test {
 protected:
  RobotModel Model(const std::string& text) {
    const std::filesystem::path path = directory_.Path() / "robot.urdf.xacro";
    WriteFileAtomically(path, text);
    return RobotModel::Open(path);
  }

  TemporaryDirectory directory_;
};

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t place = text.find(from);
  EXPECT_NE(place, std::string::npos) << from;
  return text.replace(place, from.size(), to);
}

RigidTransform InBase(const RobotModel& model, const std::string& link) {
  return model.Climb(link, {"base_link"})->T_link_start;
}

void ExpectPose(const RigidTransform& pose, const RigidTransform& expected) {
  EXPECT_LT((pose.translation - expected.translation).norm(), 1e-9);
  EXPECT_LT(AngleBetween(pose.rotation, expected.rotation), 1e-9);
}

TEST_F(UrdfMerge, AllSensorsStandWhereTheCalibrationHasThem) {
  const CalibrationResult result = SampleResult();
  RobotModel model = Model(kRobot);
  const MergedFrames merged = MergeInto(result, "", &model);
  EXPECT_EQ(merged.stayed, "imu_link");
  EXPECT_EQ(merged.updated, (std::vector<std::string>{"front_lidar_link", "cam_front_link"}));
  EXPECT_EQ(merged.appended, (std::vector<std::string>{"left_lidar_link", "right_lidar_link"}));
  const RobotModel read = Model(model.Text());
  const RigidTransform T_base_imu = InBase(read, "imu_link");
  ExpectPose(T_base_imu, {FromRollPitchYaw({0.1, 0.2, 0.3}), {0.3, 0.0, 0.2}});
  for (const SensorResult& sensor : result.sensors) {
    ExpectPose(T_base_imu.Inverse() * InBase(read, sensor.frame_id), sensor.calibration.T_imu_sensor);
  }
  EXPECT_EQ(read.ParentOf("front_lidar_link"), "mast");
  EXPECT_EQ(read.ParentOf("left_lidar_link"), "imu_link");
}

TEST_F(UrdfMerge, WhatIsNotAPoseOfASensorStaysAsItIs) {
  RobotModel model = Model(kRobot);
  EXPECT_EQ(model.Text(), kRobot);
  MergeInto(SampleResult(), "", &model);
  std::istringstream lines(Replaced(kRobot, "    <origin xyz=\"9 9 9\" rpy=\"1 1 1\"/>\n", ""));
  const std::string text = model.Text();
  std::size_t place = 0;
  for (std::string line; std::getline(lines, line);) {
    place = text.find(line + "\n", place);
    ASSERT_NE(place, std::string::npos) << line;
  }
}

TEST_F(UrdfMerge, ASecondMergeChangesNothing) {
  RobotModel model = Model(kRobot);
  MergeInto(SampleResult(), "base_link", &model);
  const std::string once = model.Text();
  RobotModel again = Model(once);
  EXPECT_EQ(again.ParentOf("left_lidar_link"), "base_link");
  EXPECT_TRUE(MergeInto(SampleResult(), "base_link", &again).appended.empty());
  EXPECT_EQ(again.Text(), once);
  EXPECT_TRUE(Contains(once, "t_imu = t_sensor + offset:"));
}

TEST_F(UrdfMerge, WithoutTheImuALidarStays) {
  CalibrationResult result = SampleResult();
  result.imu_frame_id = "imu";
  RobotModel model = Model(kRobot);
  const RigidTransform before = InBase(model, "front_lidar_link");
  const MergedFrames merged = MergeInto(result, "base_link", &model);
  EXPECT_EQ(merged.stayed, "front_lidar_link");
  EXPECT_EQ(merged.appended, (std::vector<std::string>{"imu", "left_lidar_link", "right_lidar_link"}));
  const RobotModel read = Model(model.Text());
  ExpectPose(InBase(read, "front_lidar_link"), before);
  ExpectPose(InBase(read, "front_lidar_link") * result.sensors[0].calibration.T_imu_sensor.Inverse(),
             InBase(read, "imu"));
  ExpectPose(InBase(read, "imu") * result.sensors[3].calibration.T_imu_sensor,
             InBase(read, "cam_front_link"));
}

TEST_F(UrdfMerge, TheLidarThatCarriesTheImuStays) {
  const std::string text = Replaced(kRobot, "<parent link=\"base_link\"/>\n    <child link=\"imu_link\"/>",
                                    "<parent link=\"front_lidar_link\"/>\n    <child link=\"imu_link\"/>");
  const CalibrationResult result = SampleResult();
  RobotModel model = Model(text);
  const RigidTransform before = InBase(model, "front_lidar_link");
  EXPECT_EQ(MergeInto(result, "", &model).stayed, "front_lidar_link");
  const RobotModel read = Model(model.Text());
  ExpectPose(InBase(read, "front_lidar_link"), before);
  ExpectPose(InBase(read, "imu_link") * result.sensors[0].calibration.T_imu_sensor, before);
}

TEST_F(UrdfMerge, AnyLinkOfTheModelHasAPlace) {
  const RobotModel model = Model(kRobot);
  const ModelPlacement placement(model, SampleResult());
  ExpectPose(placement.InRoot("base_link"), InBase(model, "imu_link").Inverse());
  ExpectPose(placement.InRoot("bracket"), SampleResult().sensors[0].calibration.T_imu_sensor *
                                              RigidTransform{FromRollPitchYaw({0, 0.4, 0}), {0, 0.1, 0}});
}

TEST_F(UrdfMerge, AModelIsACalibrationWithoutSigmas) {
  const RobotModel model = Model(kRobot);
  Rig rig;
  rig.imu.frame_id = "/imu_link";
  for (const char* frame : {"front_lidar_link", "none"}) {
    rig.lidars.emplace_back();
    rig.lidars.back().name = frame;
    rig.lidars.back().frame_id = frame;
  }
  CameraConfig camera;
  camera.name = "cam";
  camera.frame_id = "cam_front_link";
  rig.cameras.push_back(camera);
  camera.name = "cam_2";
  camera.intrinsics = {500, 501, 320, 240, 0, 0, 0, 0, 0};
  rig.cameras.push_back(camera);
  std::vector<std::string> left_out;
  const CalibrationResult calibration = CalibrationOfModel(model, rig, &left_out);
  ASSERT_EQ(left_out.size(), 2u);
  EXPECT_TRUE(Contains(left_out[0], "none (the model has no fixed joints from imu_link"));
  EXPECT_TRUE(Contains(left_out[1], "cam (no intrinsics"));
  ASSERT_EQ(calibration.sensors.size(), 2u);
  const RigidTransform T_imu_lidar = InBase(model, "imu_link").Inverse() * InBase(model, "front_lidar_link");
  ExpectPose(calibration.sensors[0].calibration.T_imu_sensor, T_imu_lidar);
  EXPECT_EQ(calibration.sensors[0].sigma.translation.norm(), 0.0);
  EXPECT_TRUE(std::isnan(calibration.sensors[0].sigma.time_offset));
  ASSERT_EQ(calibration.pairs.size(), 1u);
  ExpectPose(T_imu_lidar * calibration.pairs[0].T_a_b, calibration.sensors[1].calibration.T_imu_sensor);
  rig.imu.frame_id = "imu";
  EXPECT_TRUE(Contains(InputErrorOf([&] { CalibrationOfModel(model, rig, &left_out); }), "no link 'imu'"));
}

TEST_F(UrdfMerge, AModelGivesTheGuesses) {
  const RobotModel model = Model(kRobot);
  Rig rig;
  rig.imu.frame_id = "/imu_link";
  rig.lidars.resize(2);
  rig.lidars[0].frame_id = "front_lidar_link";
  rig.lidars[1].name = "none";
  rig.lidars[1].guess = ExtrinsicGuess();
  rig.lidars[1].guess->T_imu_sensor.translation.setConstant(7.0);
  rig.cameras.resize(1);
  rig.cameras[0].frame_id = "/cam_front_link";
  rig.cameras[0].guess = ExtrinsicGuess();
  std::vector<std::string> notes;
  TakeGuesses(model, &rig, &notes);
  const RigidTransform T_imu_base = InBase(model, "imu_link").Inverse();
  ASSERT_TRUE(rig.lidars[0].guess);
  ExpectPose(rig.lidars[0].guess->T_imu_sensor, T_imu_base * InBase(model, "front_lidar_link"));
  ExpectPose(rig.cameras[0].guess->T_imu_sensor, T_imu_base * InBase(model, "cam_front_link"));
  EXPECT_EQ(rig.lidars[1].guess->T_imu_sensor.translation.x(), 7.0) << "it keeps what it had";
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_TRUE(Contains(notes[0], "none: the model has no fixed joints from imu_link"));
  rig.imu.frame_id.clear();
  EXPECT_TRUE(Contains(InputErrorOf([&] { TakeGuesses(model, &rig, &notes); }), "no link ''"));
}

TEST_F(UrdfMerge, ModelsThatDoNotFitAreOneLine) {
  const auto message = [&](const std::string& text, const std::string& parent) {
    return InputErrorOf([&] {
      RobotModel model = Model(text);
      MergeInto(SampleResult(), parent, &model);
    });
  };
  EXPECT_TRUE(Contains(message("<robot", ""), "robot.urdf.xacro:1: no XML"));
  EXPECT_TRUE(Contains(message("<launch/>", ""), "expected <robot> but found <launch>"));
  EXPECT_TRUE(
      Contains(message("<robot><link name=\"a\"/></robot>", ""), "no link of the calibration (imu_link, "));
  EXPECT_TRUE(Contains(message(kRobot, "none"), "no link none"));
  EXPECT_TRUE(Contains(message(kRobot, "wheel"), "not fixed stands between the links wheel and imu_link"));
  EXPECT_TRUE(Contains(message(kRobot, "ground"), "robot.urdf.xacro:7: joint base_joint: expected numbers"));
  EXPECT_TRUE(Contains(message(Replaced(kRobot, "mount\" type=\"fixed\"", "mount\" type=\"revolute\""), ""),
                       "joint front_lidar_mount: expected type fixed"));
}

TEST_F(UrdfMerge, CheckUrdfAcceptsIt) {
  if (std::system("command -v check_urdf > /dev/null") != 0) GTEST_SKIP() << "no check_urdf on this machine";
  RobotModel model = Model(Replaced(kRobot, "${height}", "0.4"));
  MergeInto(SampleResult(), "mast", &model);
  WriteFileAtomically(directory_.Path() / "merged.urdf", model.Text());
  const std::string command = "cd '" + directory_.Path().string() + "' && check_urdf merged.urdf > log 2>&1";
  EXPECT_EQ(std::system(command.c_str()), 0) << ReadFile(directory_.Path() / "log");
  EXPECT_TRUE(Contains(ReadFile(directory_.Path() / "log"), "child(3):  right_lidar_link"));
}

}  // namespace
}  // namespace mlic::urdf_merge_test
