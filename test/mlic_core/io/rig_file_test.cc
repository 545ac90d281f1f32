#include "mlic_core/io/rig/rig_file.h"

#include "mlic_core/geometry/so3.h"
#include "mlic_core/io/text_file.h"
#include "support/files.h"
#include "support/source_directory.h"

namespace mlic::rig_file_test {
namespace {

const char* const kFull = R"(imu:
  topic: /imu/data
  frame_id: imu_link
  noise: {gyroscope: 1.0e-3, accelerometer: 1.0e-2}
  intrinsics: scale_misalignment
  alignment_sigma_deg: 0.25
  gravity: 9.7936
lidars:
  front_lidar:
    topic: /front_lidar/points
    frame_id: front_lidar
    T_imu_sensor: {xyz: [0.01, 1.69, 0.0], rpy_deg: [99.0, 89.2, 9.0]}
    sigma: {xyz: [0.1, 0.2, 0.3], rpy_deg: [5, 6, 7]}
    time_offset: 0.25
    fixed: true
    enabled: true
  left_lidar: {topic: /left/points, enabled: false}
  right_lidar: {topic: /right/points, T_imu_sensor: {xyz: [1, 2, 3], rotation: [0, 0, 0.6, 0.8]}}
cameras:
  cam_front_120:
    topic: /cam_front_120/image_raw
    model: plumb_bob
    fov_deg: 120
    intrinsics: [369.5, 369.5, 639.5, 399.5, 0, 0, 0, 0, 0]
    intrinsics_fixed: true
    shutter: rolling
    mask: front_mask.png
    T_imu_sensor: {xyz: [0, 1.97, 0], rpy_deg: [-90, 0, 0]}
)";

class RigFileTest : public ::testing::Test {
 protected:
  Rig Load(const std::string& text) {
    const std::filesystem::path path = directory_.Path() / "rig.yaml";
    WriteFileAtomically(path, text);
    return LoadRigFile(path);
  }
  std::string ErrorOf(const std::string& text) {
    const std::string message = InputErrorOf([&] { Load(text); });
    EXPECT_EQ(message.find('\n'), std::string::npos) << "more than one line: " << message;
    return message;
  }
  // The error of a rig with one LiDAR that has these keys besides its topic (line 5 on).
  std::string LidarErrorOf(const std::string& keys) {
    return ErrorOf("imu: {topic: /imu}\nlidars:\n  top:\n    topic: /top\n" + keys + "\n");
  }
  TemporaryDirectory directory_;
};

TEST_F(RigFileTest, NamesAllThatIsNotFilledIn) {
  Rig rig;
  rig.imu.topic = "/imu";
  for (const std::string name : {"one", "two"}) {
    rig.cameras.emplace_back().name = name;
    rig.cameras.back().topic = "/" + name;
  }
  const std::filesystem::path path = directory_.Path() / "draft.yaml";
  WriteRigFile(path, rig);
  const std::string message = InputErrorOf([&] { LoadRigFile(path); });
  for (const char* part : {"draft.yaml:", "???", "cameras.one.fov_deg, cameras.two.fov_deg"})
    EXPECT_NE(message.find(part), std::string::npos) << part << " in: " << message;
  EXPECT_NE(
      ErrorOf("imu: {topic: /imu}\ncameras:\n  one: {topic: /one}\n").find("neither intrinsics nor fov_deg"),
      std::string::npos);
}

TEST_F(RigFileTest, ReadsEveryKey) {
  const Rig rig = Load(kFull);
  EXPECT_EQ(rig.imu.topic, "/imu/data");
  EXPECT_EQ(rig.imu.frame_id, "imu_link");
  EXPECT_DOUBLE_EQ(rig.imu.noise->accelerometer, 1e-2);
  EXPECT_EQ(rig.imu.intrinsics, ImuIntrinsicsModel::kScaleMisalignment);
  EXPECT_NEAR(rig.imu.alignment_sigma, 0.25 * M_PI / 180.0, 1e-15);
  EXPECT_EQ(rig.imu.gravity, 9.7936);
  ASSERT_EQ(rig.lidars.size(), 2u) << "the disabled one is left out";
  const LidarConfig& front = rig.lidars[0];
  EXPECT_EQ(front.name, "front_lidar");
  EXPECT_TRUE(front.fixed);
  EXPECT_DOUBLE_EQ(*front.time_offset, 0.25);
  const Eigen::Vector3d rpy = Eigen::Vector3d(99.0, 89.2, 9.0) * M_PI / 180.0;
  const Eigen::Matrix3d expected = (Eigen::AngleAxisd(rpy.z(), Eigen::Vector3d::UnitZ()) *
                                    Eigen::AngleAxisd(rpy.y(), Eigen::Vector3d::UnitY()) *
                                    Eigen::AngleAxisd(rpy.x(), Eigen::Vector3d::UnitX()))
                                       .toRotationMatrix();
  EXPECT_LT((front.guess->T_imu_sensor.rotation.toRotationMatrix() - expected).norm(), 1e-12);
  EXPECT_DOUBLE_EQ(front.guess->sigma_translation.y(), 0.2);
  EXPECT_NEAR(front.guess->sigma_rotation.z(), 7.0 * M_PI / 180.0, 1e-15);
  ASSERT_TRUE(front.held_sigma);
  EXPECT_EQ(front.held_sigma->rotation, front.guess->sigma_rotation);
  const LidarConfig& right = rig.lidars[1];
  EXPECT_FALSE(right.held_sigma) << "it is not fixed";
  EXPECT_TRUE(right.frame_id.empty());
  EXPECT_FALSE(right.fixed);
  EXPECT_DOUBLE_EQ(right.guess->T_imu_sensor.rotation.z(), 0.6);
  EXPECT_DOUBLE_EQ(right.guess->sigma_translation.x(), 0.1) << "the default of a guess without sigma";
  ASSERT_EQ(rig.cameras.size(), 1u);
  EXPECT_EQ(rig.cameras[0].shutter, Shutter::kRolling);
  EXPECT_DOUBLE_EQ(*rig.cameras[0].fov_deg, 120.0);
  EXPECT_EQ(rig.cameras[0].intrinsics->size(), 9u);
  EXPECT_TRUE(rig.cameras[0].intrinsics_fixed);
  EXPECT_EQ(rig.cameras[0].mask, "front_mask.png");
}

TEST_F(RigFileTest, AFixedSensorIsExactWhereItHasNoSigma) {
  const std::string fixed = "    T_imu_sensor: {xyz: [0, 0, 1], rpy_deg: [0, 0, 0]}\n    fixed: true\n";
  const std::string start = "imu: {topic: /imu}\nlidars:\n  top:\n    topic: /top\n" + fixed;
  EXPECT_FALSE(Load(start).lidars[0].held_sigma);
  const Rig rig = Load(start + "    sigma: {xyz: [0.01, 0.02, 0.03]}\n");
  ASSERT_TRUE(rig.lidars[0].held_sigma);
  EXPECT_EQ(rig.lidars[0].held_sigma->translation, Eigen::Vector3d(0.01, 0.02, 0.03));
  EXPECT_TRUE(rig.lidars[0].held_sigma->rotation.isZero(0.0));
  WriteRigFile(directory_.Path() / "copy.yaml", rig);
  const LidarConfig copy = LoadRigFile(directory_.Path() / "copy.yaml").lidars[0];
  EXPECT_EQ(copy.held_sigma->translation, rig.lidars[0].held_sigma->translation);
  EXPECT_TRUE(copy.held_sigma->rotation.isZero(0.0));
}

TEST_F(RigFileTest, NamesItsVersion) {
  const std::string rest = "imu: {topic: /imu}\nlidars:\n  top: {topic: /top}\n";
  EXPECT_EQ(Load("format: mlic_rig/1\n" + rest).lidars.size(), 1u);
  EXPECT_TRUE(Contains(ErrorOf("format: mlic_rig/2\nfuture: 1\n" + rest),
                       "rig.yaml:1: format: 'mlic_rig/2' was written by a newer MLIC than this one"));
  EXPECT_TRUE(Contains(ErrorOf("format: mlic_calibration/1\nsensors: {}\n"),
                       "another kind of file; expected mlic_rig/1"));
}

TEST_F(RigFileTest, WritesWhatItReads) {
  Rig rig = Load(kFull);
  rig.lidars[1].guess->T_imu_sensor.rotation = FromRollPitchYaw({0.3, M_PI / 2, -0.7});  // gimbal lock
  const std::filesystem::path path = directory_.Path() / "copy" / "rig.yaml";
  WriteRigFile(path, rig);
  const Rig copy = LoadRigFile(path);
  ASSERT_EQ(copy.lidars.size(), rig.lidars.size());
  for (std::size_t i = 0; i < rig.lidars.size(); ++i) {
    const RigidTransform& a = rig.lidars[i].guess->T_imu_sensor;
    const RigidTransform& b = copy.lidars[i].guess->T_imu_sensor;
    EXPECT_LT(AngleBetween(a.rotation, b.rotation), 1e-9);
    EXPECT_LT((a.translation - b.translation).norm(), 1e-9);
    EXPECT_LT((rig.lidars[i].guess->sigma_rotation - copy.lidars[i].guess->sigma_rotation).norm(), 1e-10);
    EXPECT_EQ(copy.lidars[i].name, rig.lidars[i].name);
    EXPECT_EQ(copy.lidars[i].topic, rig.lidars[i].topic);
    EXPECT_EQ(copy.lidars[i].fixed, rig.lidars[i].fixed);
    EXPECT_EQ(copy.lidars[i].time_offset, rig.lidars[i].time_offset);
  }
  EXPECT_EQ(copy.imu.intrinsics, rig.imu.intrinsics);
  EXPECT_EQ(copy.cameras[0].intrinsics, rig.cameras[0].intrinsics);
  EXPECT_TRUE(copy.cameras[0].intrinsics_fixed);
  EXPECT_EQ(copy.cameras[0].shutter, rig.cameras[0].shutter);
  EXPECT_EQ(copy.cameras[0].mask, rig.cameras[0].mask);
  WriteRigFile(directory_.Path() / "again.yaml", copy);
  EXPECT_EQ(ReadFile(directory_.Path() / "again.yaml"), ReadFile(path));
}

TEST_F(RigFileTest, UnknownKeyNamesFileLineAndKey) {
  const std::string message = LidarErrorOf("    time_ofset: 0.1");
  EXPECT_TRUE(Contains(message, "rig.yaml:5: lidars.top.time_ofset: unknown key 'time_ofset'"));
  EXPECT_TRUE(Contains(message, "time_offset"));
  EXPECT_TRUE(Contains(ErrorOf("imu: {topic: /imu}\nlidar:\n  top: {topic: /top}\n"), "rig.yaml:2: lidar"));
}

TEST_F(RigFileTest, MissingPartsAreNamed) {
  EXPECT_TRUE(Contains(ErrorOf("lidars:\n  top: {topic: /top}\n"), "'imu' is missing"));
  EXPECT_TRUE(Contains(ErrorOf("imu: {frame_id: i}\nlidars:\n  top: {topic: /t}\n"), "'topic' is missing"));
  EXPECT_TRUE(Contains(ErrorOf("imu: {topic: /imu}\nlidars:\n  top: {frame_id: t}\n"),
                       "rig.yaml:3: lidars.top: key 'topic' is missing"));
  EXPECT_TRUE(Contains(ErrorOf("imu: {topic: /imu}\n"), "no enabled sensor"));
  EXPECT_TRUE(Contains(ErrorOf("imu: {topic: /imu}\nlidars:\n  top: {topic: /t, enabled: false}\n"),
                       "no enabled sensor"));
  EXPECT_TRUE(Contains(ErrorOf(""), "expected a mapping"));
  EXPECT_TRUE(
      Contains(InputErrorOf([&] { LoadRigFile(directory_.Path() / "none.yaml"); }), "none.yaml: cannot be"));
  EXPECT_TRUE(Contains(ErrorOf("imu: {topic: /imu\nlidars:\n"), "not valid YAML"));
}

TEST_F(RigFileTest, WrongValuesAreNamed) {
  EXPECT_TRUE(Contains(LidarErrorOf("    time_offset: soon"),
                       "rig.yaml:5: lidars.top.time_offset: expected a finite"));
  EXPECT_TRUE(Contains(LidarErrorOf("    time_offset: .nan"), "finite number"));
  EXPECT_TRUE(Contains(LidarErrorOf("    time_offset: 50"), "seconds are expected"));
  EXPECT_TRUE(Contains(LidarErrorOf("    enabled: maybe"), "expected true or false"));
  EXPECT_TRUE(Contains(LidarErrorOf("    fixed: true"), "give T_imu_sensor"));
  const std::string camera =
      "imu: {topic: /imu}\ncameras:\n  one: {topic: /one, fov_deg: 90, intrinsics_fixed: true}\n";
  EXPECT_TRUE(Contains(ErrorOf(camera), "give intrinsics too"));
  EXPECT_TRUE(Contains(LidarErrorOf("    sigma: {xyz: [1, 1, 1]}"), "sigma belongs to a guess"));
  EXPECT_TRUE(Contains(LidarErrorOf("    topic: /other"), "there twice"));
  EXPECT_TRUE(Contains(ErrorOf("imu: {topic: /imu, noise: {gyroscope: -1, accelerometer: 1}}\nlidars:\n"
                               "  top: {topic: /top}\n"),
                       "must be positive"));
  EXPECT_TRUE(Contains(ErrorOf("imu: {topic: /imu, intrinsics: all}\nlidars:\n  top: {topic: /top}\n"),
                       "choose one of: bias, scale_misalignment"));
}

TEST_F(RigFileTest, WrongPosesAreNamed) {
  const auto pose = [&](const std::string& text) { return LidarErrorOf("    T_imu_sensor: {" + text + "}"); };
  EXPECT_TRUE(Contains(pose("xyz: [0, 0], rpy_deg: [0, 0, 0]"), "expected 3 numbers"));
  EXPECT_TRUE(Contains(pose("xyz: [0, 0, 0]"), "exactly one of"));
  EXPECT_TRUE(Contains(pose("xyz: [0, 0, 0], rpy_deg: [0, 0, 0], rotation: [0, 0, 0, 1]"), "exactly one of"));
  EXPECT_TRUE(Contains(pose("xyz: [0, 0, 0], rotation: [0, 0, 1, 1]"), "not a unit quaternion"));
  EXPECT_TRUE(Contains(pose("xyz: [0, 0, 1690], rpy_deg: [0, 0, 0]"), "metres are expected"));
  EXPECT_TRUE(Contains(pose("xyz: [0, 0, 0], rpy_deg: [0, 0, 400]"), "degrees"));
  EXPECT_TRUE(Contains(pose("xyz: [0, 0, 0], rpy: [0, 0, 1]"), "unknown key 'rpy'"));
  EXPECT_TRUE(Contains(LidarErrorOf("    T_imu_sensor: {xyz: [0, 0, 0], rpy_deg: [0, 0, 0]}\n"
                                    "    sigma: {xyz: [0.1, -0.1, 0.1]}"),
                       "rig.yaml:6"));
}

TEST_F(RigFileTest, SensorsMustDiffer) {
  const std::string head = "imu: {topic: /imu}\nlidars:\n  a: {topic: /a, frame_id: f}\n";
  EXPECT_TRUE(Contains(ErrorOf(head + "  b: {topic: /a}\n"), "topic '/a' is already used at"));
  EXPECT_TRUE(Contains(ErrorOf(head + "  b: {topic: /b, frame_id: f}\n"), "frame_id 'f' is already used"));
  EXPECT_TRUE(Contains(ErrorOf(head + "cameras:\n  a: {topic: /b}\n"), "name 'a' is already used"));
  EXPECT_TRUE(Contains(ErrorOf(head + "  b/c: {topic: /b}\n"), "letters, digits"));
  EXPECT_EQ(Load(head + "  b: {topic: /a, enabled: false}\n").lidars.size(), 1u);
}

TEST_F(RigFileTest, CameraIntrinsicsMustFitTheModel) {
  const std::string head = "imu: {topic: /imu}\ncameras:\n  c:\n    topic: /c\n    model: equidistant\n";
  EXPECT_TRUE(Contains(ErrorOf(head + "    intrinsics: [1, 1, 1, 1, 0]\n"), "expected 8 numbers"));
  EXPECT_EQ(Load(head + "    intrinsics: [1, 1, 1, 1, 0, 0, 0, 0]\n").cameras.size(), 1u);
}

TEST(ShippedRigs, LoadAndName) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(SourceDirectory() + "/config/rigs")) {
    if (entry.path().extension() != ".yaml") continue;
    EXPECT_FALSE(LoadRigFile(entry.path()).lidars.empty()) << entry.path();
    ++count;
  }
  EXPECT_GE(count, 2);
}

}  // namespace
}  // namespace mlic::rig_file_test
