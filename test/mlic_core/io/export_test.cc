#include <cstdlib>
#include <cstring>
#include <regex>

#include "mlic_core/geometry/so3.h"
#include "mlic_core/io/result/export_frames.h"
#include "mlic_core/io/result/point_cloud_file.h"
#include "mlic_core/io/result/result_file.h"
#include "mlic_core/io/result/sensor_tree.h"
#include "mlic_core/io/result/static_transforms.h"
#include "mlic_core/io/result/trajectory_file.h"
#include "mlic_core/io/result/urdf.h"
#include "mlic_core/io/text_file.h"
#include "mlic_core/io/write_results.h"
#include "support/files.h"
#include "support/sample_result.h"

namespace mlic::export_test {
namespace {

// The numbers in the attribute `name="..."` at its i-th place in the text.
std::vector<double> Numbers(const std::string& text, const std::string& attribute, std::size_t i) {
  const std::regex pattern("\\b" + attribute + "=\"([^\"]*)\"");
  auto match = std::sregex_iterator(text.begin(), text.end(), pattern);
  for (; i > 0; --i) ++match;
  std::istringstream words((*match)[1].str());
  std::vector<double> numbers;
  for (double number = 0.0; words >> number;) numbers.push_back(number);
  return numbers;
}

TEST(Export, UrdfHoldsThePosesAndCheckUrdfAcceptsIt) {
  TemporaryDirectory directory;
  const CalibrationResult result = SampleResult();
  const std::filesystem::path path = directory.Path() / "sensors.urdf.xacro";
  WriteFileAtomically(path, UrdfText(TreeOf(result)));
  const std::string text = ReadFile(path);
  for (std::size_t i = 0; i < result.sensors.size(); ++i) {
    const RigidTransform& pose = result.sensors[i].calibration.T_imu_sensor;
    const std::vector<double> rpy = Numbers(text, "rpy", i), xyz = Numbers(text, "xyz", i);
    EXPECT_LT(AngleBetween(FromRollPitchYaw({rpy[0], rpy[1], rpy[2]}), pose.rotation), 1e-9);
    EXPECT_LT((Eigen::Vector3d(xyz[0], xyz[1], xyz[2]) - pose.translation).norm(), 1e-11);
  }
  if (std::system("command -v check_urdf > /dev/null") != 0) GTEST_SKIP() << "no check_urdf on this machine";
  const std::string command =
      "check_urdf '" + path.string() + "' > '" + (directory.Path() / "log").string() + "' 2>&1";
  EXPECT_EQ(std::system(command.c_str()), 0) << ReadFile(directory.Path() / "log");
  EXPECT_TRUE(Contains(ReadFile(directory.Path() / "log"), "imu_link has 4 child"));
}

TEST(Export, StaticTransformsHoldPositionQuaternionAndFrames) {
  TemporaryDirectory directory;
  const CalibrationResult result = SampleResult();
  WriteFileAtomically(directory.Path() / "static.launch",
                      StaticTransformsText(TreeOf(result), TransformPublisher::kTf2));
  const std::string text = ReadFile(directory.Path() / "static.launch");
  const std::vector<double> numbers = Numbers(text, "args", 1);
  ASSERT_EQ(numbers.size(), 7u);
  const RigidTransform& pose = result.sensors[1].calibration.T_imu_sensor;
  EXPECT_NEAR(numbers[0], pose.translation.x(), 1e-9);
  EXPECT_NEAR(numbers[3], pose.rotation.x(), 1e-11);
  EXPECT_NEAR(numbers[6], pose.rotation.w(), 1e-11);
  EXPECT_TRUE(Contains(text, " imu_link left_lidar_link\""));
  EXPECT_TRUE(Contains(text, "pkg=\"tf2_ros\" type=\"static_transform_publisher\" name=\"mlic_left_lidar\""));
}

// The poses in the file are checked by what roslaunch and the publishers make of it: arguments as words.
TEST(Export, TfHasAPeriodAndTheImuBelowAnotherParent) {
  const CalibrationResult result = SampleResult();
  const RigidTransform T_base_imu{FromRollPitchYaw({0.01, -0.02, 1.5}), {0.3, -0.1, 0.7}};
  const SensorTree tree = TreeAbout(result, "base_link", T_base_imu);
  const std::string text = StaticTransformsText(tree, TransformPublisher::kTf);
  ASSERT_EQ(tree.frames.size(), 5u);
  for (std::size_t i = 0; i < tree.frames.size(); ++i) {
    const std::vector<double> numbers = Numbers(text, "args", i);
    ASSERT_EQ(numbers.size(), 7u);
    const RigidTransform expected =
        i == 0 ? T_base_imu : T_base_imu * result.sensors[i - 1].calibration.T_imu_sensor;
    EXPECT_LT((Eigen::Vector3d(numbers[0], numbers[1], numbers[2]) - expected.translation).norm(), 1e-9);
    const Eigen::Quaterniond q(numbers[6], numbers[3], numbers[4], numbers[5]);
    EXPECT_LT(AngleBetween(q, expected.rotation), 1e-9);
  }
  EXPECT_TRUE(Contains(text, "pkg=\"tf\" type=\"static_transform_publisher\" name=\"mlic_imu\""));
  EXPECT_TRUE(Contains(text, " base_link imu_link 100\""));
  EXPECT_TRUE(Contains(text, "t_imu = t_sensor + offset:\n       front_lidar 0.012357679 s"));
}

TEST(Export, ASensorMayBeTheParent) {
  const CalibrationResult result = SampleResult();
  for (const char* parent : {"left_lidar", "left_lidar_link"}) {
    const std::optional<RigidTransform> T_left_imu = RootInFrame(result, parent);
    ASSERT_TRUE(T_left_imu);
    const SensorTree tree = TreeAbout(result, FrameNamed(result, parent), *T_left_imu);
    EXPECT_EQ(tree.parent, "left_lidar_link");
    ASSERT_EQ(tree.frames.size(), 4u);
    EXPECT_EQ(tree.frames[2].frame, "right_lidar_link");
    const RigidTransform expected =
        result.sensors[1].calibration.T_imu_sensor.Inverse() * result.sensors[2].calibration.T_imu_sensor;
    EXPECT_LT((tree.frames[2].T_parent_frame.translation - expected.translation).norm(), 1e-12);
  }
  EXPECT_EQ(FrameNamed(result, "imu"), "imu_link");
  EXPECT_FALSE(RootInFrame(result, "base_link"));
}

// xacro itself expands the macro into a model that has the IMU's link already.
TEST(Export, TheMacroGoesIntoAModelOfItsOwn) {
  if (std::system("command -v xacro > /dev/null") != 0) GTEST_SKIP() << "no xacro on this machine";
  TemporaryDirectory directory;
  const CalibrationResult result = SampleResult();
  WriteFileAtomically(directory.Path() / "sensors_macro.xacro", UrdfMacroText(TreeOf(result)));
  WriteFileAtomically(directory.Path() / "robot.xacro",
                      "<robot name=\"car\" xmlns:xacro=\"http://www.ros.org/wiki/xacro\">\n"
                      "<xacro:include filename=\"sensors_macro.xacro\"/>\n<link name=\"imu_link\"/>\n"
                      "<link name=\"other\"/>\n<xacro:mlic_sensors/>\n</robot>\n");
  const std::string command = "cd '" + directory.Path().string() + "' && xacro robot.xacro > robot.urdf";
  ASSERT_EQ(std::system(command.c_str()), 0);
  const std::string text = ReadFile(directory.Path() / "robot.urdf");
  for (std::size_t i = 0; i < result.sensors.size(); ++i) {
    const RigidTransform& pose = result.sensors[i].calibration.T_imu_sensor;
    const std::vector<double> rpy = Numbers(text, "rpy", i), xyz = Numbers(text, "xyz", i);
    EXPECT_LT(AngleBetween(FromRollPitchYaw({rpy[0], rpy[1], rpy[2]}), pose.rotation), 1e-9);
    EXPECT_LT((Eigen::Vector3d(xyz[0], xyz[1], xyz[2]) - pose.translation).norm(), 1e-9);
  }
  EXPECT_TRUE(Contains(text, "<parent link=\"imu_link\"/>"));
  EXPECT_EQ(text.find("<link name=\"imu_link\"/>"), text.rfind("<link name=\"imu_link\"/>"));
}

TEST(Export, FramesAreUniqueAndWithoutSlash) {
  CalibrationResult result = SampleResult();
  result.imu_frame_id = "/imu";
  result.sensors[0].frame_id = "/velodyne";
  result.sensors[1].frame_id = "velodyne";
  result.sensors[2].frame_id = "";
  result.sensors[3].frame_id = "imu";
  const ExportFrames frames = FramesOf(result);
  EXPECT_EQ(frames.root, "imu");
  EXPECT_EQ(frames.sensors, (std::vector<std::string>{"velodyne", "left_lidar", "right_lidar", "cam_front"}));
}

TEST(Export, PairsAreAboutTheRoot) {
  TemporaryDirectory directory;
  CalibrationResult result;
  result.verdict = Verdict::kPartial;
  result.root = "roof";
  result.imu_frame_id = "imu";
  for (const char* name : {"front", "roof", "rear", "left"}) {
    result.rejected.push_back({name, SensorResult::Type::kLidar, "parked", std::string(name) + "_link"});
  }
  const RigidTransform T{FromRollPitchYaw({0.1, 0.2, 0.3}), {1.0, 2.0, 3.0}};
  result.pairs = {{"front", "roof", T, {}}, {"front", "rear", T, {}}, {"roof", "rear", T, {}}};
  const std::vector<ExportedSensor> exported = ExportedSensors(result);
  ASSERT_EQ(exported.size(), 2u);
  EXPECT_EQ(exported[0].name, "front");
  EXPECT_LT((exported[0].T_root_sensor.translation - T.Inverse().translation).norm(), 1e-12);
  EXPECT_EQ(exported[1].name, "rear");
  EXPECT_LT((exported[1].T_root_sensor.translation - T.translation).norm(), 1e-12);
  EXPECT_EQ(FramesOf(result).root, "roof_link");
  WriteFileAtomically(directory.Path() / "static.launch",
                      StaticTransformsText(TreeOf(result), TransformPublisher::kTf2));
  WriteFileAtomically(directory.Path() / "sensors.urdf", UrdfText(TreeOf(result)));
  EXPECT_TRUE(Contains(ReadFile(directory.Path() / "static.launch"), " roof_link rear_link\""));
  EXPECT_TRUE(Contains(ReadFile(directory.Path() / "sensors.urdf"), "<parent link=\"roof_link\"/>"));
  EXPECT_FALSE(Contains(ReadFile(directory.Path() / "sensors.urdf"), "imu"));
}

TEST(Export, AWordOfAShellIsQuotedWhereItMustBe) {
  EXPECT_EQ(ShellQuoted("/data/drive_1.bag"), "/data/drive_1.bag");
  EXPECT_EQ(ShellQuoted("/my data/it's"), "'/my data/it'\\''s'");
  EXPECT_EQ(ShellQuoted(""), "''");
}

TEST(Export, TrajectoryKeepsNanoseconds) {
  TemporaryDirectory directory;
  const std::filesystem::path path = directory.Path() / "trajectory.tum";
  std::vector<StampedPose> trajectory;
  for (const TimeNs time : {-1500000001LL, -1LL, 0LL, 7LL, 1700000000123456789LL}) {
    trajectory.push_back({time, {FromRollPitchYaw({0.1, -0.2, 3.0}), {1.0, -2.5, 1e-7}}});
  }
  WriteTrajectoryFile(path, trajectory);
  EXPECT_TRUE(Contains(ReadFile(path), "\n1700000000.123456789 1.000000000 -2.500000000 "));
  EXPECT_TRUE(Contains(ReadFile(path), "\n-1.500000001 "));
  const std::vector<StampedPose> copy = ReadTrajectoryFile(path);
  ASSERT_EQ(copy.size(), trajectory.size());
  for (std::size_t i = 0; i < copy.size(); ++i) {
    EXPECT_EQ(copy[i].time, trajectory[i].time);
    EXPECT_LT((copy[i].pose.translation - trajectory[i].pose.translation).norm(), 1e-9);
    EXPECT_LT(AngleBetween(copy[i].pose.rotation, trajectory[i].pose.rotation), 1e-11);
  }
  WriteFileAtomically(path, "# comment\n1.0 0 0 0 0 0 0 1\n2.0 0 0 zero 0 0 0 1\n");
  EXPECT_TRUE(Contains(InputErrorOf([&] { ReadTrajectoryFile(path); }), "trajectory.tum:3: expected a pose"));
}

TEST(Export, PointCloudHasHeaderAndBinaryFields) {
  TemporaryDirectory directory;
  const CalibrationResult result = SampleResult();
  WritePointCloudFile(directory.Path() / "map.pcd", result.map);
  const std::string content = ReadFile(directory.Path() / "map.pcd");
  EXPECT_TRUE(Contains(content.substr(0, 400),
                       "FIELDS x y z intensity lidar plane\nSIZE 4 4 4 4 4 4\nTYPE F F F F I I\n"));
  EXPECT_TRUE(Contains(content.substr(0, 400), "POINTS 20000\nDATA binary\n"));
  const std::size_t data = content.find("DATA binary\n") + 12;
  ASSERT_EQ(content.size(), data + 24 * result.map.size());
  float xyzi[4];
  std::int32_t indices[2];
  std::memcpy(xyzi, content.data() + data + 24 * 1234, 16);
  std::memcpy(indices, content.data() + data + 24 * 1234 + 16, 8);
  EXPECT_EQ(xyzi[1], result.map[1234].position.y());
  EXPECT_EQ(xyzi[3], result.map[1234].intensity);
  EXPECT_EQ(indices[0], result.map[1234].lidar);
  EXPECT_EQ(indices[1], result.map[1234].plane);
}

TEST(Export, ColouredPointsHaveThePackedColoursOfPcl) {
  TemporaryDirectory directory;
  ColouredPoint point;
  point.position = {1.5f, -2.0f, 0.25f};
  point.bgr = {1, 2, 3};
  WriteColouredPointCloudFile(directory.Path() / "map.pcd", {point, point});
  const std::string content = ReadFile(directory.Path() / "map.pcd");
  EXPECT_TRUE(Contains(content.substr(0, 400), "FIELDS x y z rgb\nSIZE 4 4 4 4\n"));
  const std::size_t data = content.find("DATA binary\n") + 12;
  ASSERT_EQ(content.size(), data + 2 * 16);
  float xyz[3];
  std::uint32_t rgb = 0;
  std::memcpy(xyz, content.data() + data + 16, 12);
  std::memcpy(&rgb, content.data() + data + 28, 4);
  EXPECT_EQ(xyz[1], -2.0f);
  EXPECT_EQ(rgb, 0x030201u);
}

// Frames that a shell, an XML parser, roslaunch or xacro would take apart or evaluate.
CalibrationResult ResultWithHostileFrames() {
  CalibrationResult result = SampleResult();
  result.imu_frame_id = "imu 'of' <the> car";
  result.sensors[0].frame_id = "$(env HOME) ${1+1}";
  result.sensors[1].frame_id = "left \"lidar\" & more";
  result.sensors[2].frame_id = "/right:=other";
  result.sensors[3].frame_id = "cam\nfront \xff";
  return result;
}

TEST(Export, FramesThatWouldBeEvaluatedFallBackToTheName) {
  const ExportFrames frames = FramesOf(ResultWithHostileFrames());
  EXPECT_EQ(frames.root, "imu 'of' <the> car");
  EXPECT_EQ(frames.sensors,
            (std::vector<std::string>{"front_lidar", "left \"lidar\" & more", "right_lidar", "cam_front"}));
  ASSERT_EQ(frames.notes.size(), 3u);
  EXPECT_TRUE(Contains(frames.notes[0], "front_lidar: its frame '$(env HOME) ${1+1}'"));
  EXPECT_TRUE(Contains(frames.notes[2], "cam?front ?")) << "no control characters on the terminal";
  CalibrationResult result;
  result.imu_frame_id = "$(find mlic)";
  EXPECT_EQ(FramesOf(result).root, "imu");
  EXPECT_TRUE(FramesOf(SampleResult()).notes.empty());
}

// Reads the files as roslaunch and robot_state_publisher do: an XML parser, and shlex for the arguments.
TEST(Export, FilesAreReadBackWithTheFramesThatTheyGot) {
  if (std::system("command -v /usr/bin/python3 > /dev/null") != 0)
    GTEST_SKIP() << "no python3 on this machine";
  TemporaryDirectory directory;
  const CalibrationResult result = ResultWithHostileFrames();
  WriteFileAtomically(directory.Path() / "static.launch",
                      StaticTransformsText(TreeOf(result), TransformPublisher::kTf2));
  WriteFileAtomically(directory.Path() / "sensors.urdf", UrdfText(TreeOf(result)));
  for (const char* name : {"static.launch", "sensors.urdf"}) {
    EXPECT_EQ(ReadFile(directory.Path() / name).find('$'), std::string::npos) << name;
  }
  WriteFileAtomically(directory.Path() / "read.py",
                      "import shlex, xml.etree.ElementTree as tree\n"
                      "for node in tree.parse('static.launch').getroot():\n"
                      "    words = shlex.split(node.get('args'))\n"
                      "    print(len(words), *words[7:], sep='|')\n"
                      "robot = tree.parse('sensors.urdf').getroot()\n"
                      "print(*(link.get('name') for link in robot.iter('link')), sep='|')\n"
                      "print(*(child.get('link') for child in robot.iter('child')), sep='|')\n");
  const std::string command =
      "cd '" + directory.Path().string() + "' && /usr/bin/python3 read.py > read.txt 2>&1";
  std::system(command.c_str());
  const std::string imu = "imu 'of' <the> car", left = "left \"lidar\" & more";
  EXPECT_EQ(ReadFile(directory.Path() / "read.txt"),
            "9|" + imu + "|front_lidar\n9|" + imu + "|" + left + "\n9|" + imu + "|right_lidar\n9|" + imu +
                "|cam_front\n" + imu + "|front_lidar|" + left + "|right_lidar|cam_front\nfront_lidar|" +
                left + "|right_lidar|cam_front\n");
}

TEST(WriteResults, RefusedGetsNothingThatOthersWouldLoad) {
  TemporaryDirectory directory;
  CalibrationResult result = SampleResult();
  result.trajectories.push_back(result.trajectories[0]);
  WriteResults(directory.Path() / "trusted", result, "/data");
  for (const char* name :
       {"calibration.yaml", "report.html", "trajectory.tum", "trajectory_2.tum", "map.pcd",
        "static_transforms.launch", "sensors.urdf.xacro", "sensors_macro.xacro", "kalibr_camchain.yaml",
        "camera_info/cam_front.yaml", "images/cam_front_tracks.png", "images/keyframes.csv",
        "initial_calibration.yaml"}) {
    EXPECT_TRUE(std::filesystem::exists(directory.Path() / "trusted" / name)) << name;
  }
  result.verdict = Verdict::kPartial;
  WriteResults(directory.Path() / "partial", result, "/data");
  EXPECT_TRUE(std::filesystem::exists(directory.Path() / "partial" / "static_transforms.launch"));
  CalibrationResult refused;
  refused.reasons = {"the vehicle stood still"};
  const std::filesystem::path output = directory.Path() / "refused";
  WriteResults(output, refused, "/data");
  std::vector<std::string> left;
  for (const auto& entry : std::filesystem::directory_iterator(output))
    left.push_back(entry.path().filename());
  std::sort(left.begin(), left.end());
  EXPECT_EQ(left, (std::vector<std::string>{"calibration.yaml", "report.html"}));
  EXPECT_FALSE(ReadCalibrationFile(output / "calibration.yaml").Trusted());
}

TEST(WriteResults, SameResultSameBytes) {
  TemporaryDirectory directory;
  WriteResults(directory.Path() / "a", SampleResult(), "/data");
  WriteResults(directory.Path() / "b", SampleResult(), "/data");
  for (const auto& entry : std::filesystem::directory_iterator(directory.Path() / "a")) {
    if (entry.is_directory()) continue;
    EXPECT_EQ(ReadFile(entry.path()), ReadFile(directory.Path() / "b" / entry.path().filename()))
        << entry.path();
  }
}

TEST(WriteResults, UnwritablePlaceIsOneLine) {
  TemporaryDirectory directory;
  WriteFileAtomically(directory.Path() / "file", "x");
  EXPECT_TRUE(Contains(
      InputErrorOf([&] { WriteResults(directory.Path() / "file" / "sub", SampleResult(), ""); }), "file"));
}

}  // namespace
}  // namespace mlic::export_test
