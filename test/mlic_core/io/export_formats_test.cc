// Each format is read back, by the library its program reads it with where that is one of ours, and compared
// with the calibration. Formats of poses alone: export_test.cc and urdf_merge_test.cc.
#include "mlic_core/io/result/export_formats.h"

#include <yaml-cpp/yaml.h>

#include <map>
#include <opencv2/core.hpp>

#include "mlic_core/geometry/so3.h"
#include "mlic_core/io/result/robot_model.h"
#include "mlic_core/io/text_file.h"
#include "support/files.h"
#include "support/sample_result.h"

namespace mlic::export_formats_test {
namespace {

constexpr double kNear = 1e-9;  // m, rad, s, px

// Three LiDARs, a fisheye camera and a pinhole camera.
CalibrationResult TwoCameras() {
  CalibrationResult result = SampleResult();
  SensorResult pinhole = result.sensors[3];
  pinhole.name = "cam_rear";
  pinhole.frame_id = "cam_rear_link";
  pinhole.calibration.T_imu_sensor = {FromRollPitchYaw({-1.5, 0.1, 2.7}), {0.3, -0.2, 1.0}};
  pinhole.calibration.time_offset = -0.0125;
  pinhole.intrinsics = CameraIntrinsics{
      CameraModel::kPlumbBob, 640, 480, {500.25, 501.5, 320.125, 240.5, 0.1, -0.02, 1e-5, 0.0004, 0.0}};
  result.sensors.push_back(pinhole);
  result.sensors[0].corrections = {0.0, 0.0, 0.0, 0.0, {{7, 0.004, -0.001}}};
  return result;
}

std::map<std::string, std::string> Export(const std::string& format) {
  const CalibrationResult result = TwoCameras();
  std::map<std::string, std::string> files;
  for (const ExportedFile& file : ExportFormatNamed(format).write(result, TreeOf(result))) {
    EXPECT_TRUE(files.emplace(file.name, file.text).second) << "two files of one name";
  }
  return files;
}

void ExpectPose(const RigidTransform& pose, const RigidTransform& expected) {
  EXPECT_LT((pose.translation - expected.translation).norm(), kNear);
  EXPECT_LT(AngleBetween(pose.rotation, expected.rotation), kNear);
}

void ExpectNear(const std::vector<double>& values, const std::vector<double>& expected) {
  ASSERT_EQ(values.size(), expected.size());
  for (std::size_t i = 0; i < values.size(); ++i) EXPECT_NEAR(values[i], expected[i], kNear);
}

RigidTransform Pose(const cv::Mat& T) {
  Eigen::Matrix3d R;
  for (int i = 0; i < 9; ++i) R(i / 3, i % 3) = T.at<double>(i / 3, i % 3);
  return {Eigen::Quaterniond(R), {T.at<double>(0, 3), T.at<double>(1, 3), T.at<double>(2, 3)}};
}

RigidTransform Pose(const YAML::Node& rotation, const YAML::Node& translation) {
  const auto R = rotation.as<std::vector<double>>();
  const auto t = translation.as<std::vector<double>>();
  EXPECT_EQ(R.size(), 9u);
  return {Eigen::Quaterniond(
              Eigen::Matrix3d(Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(R.data()))),
          {t[0], t[1], t[2]}};
}

cv::FileStorage Opened(const std::string& text) {
  return cv::FileStorage(text, cv::FileStorage::READ | cv::FileStorage::MEMORY);
}

TEST(ExportFormats, EachSaysItsDirectionAndTheSignOfTime) {
  for (const ExportFormat& format : ExportFormats()) {
    const std::map<std::string, std::string> files = Export(format.name);
    EXPECT_FALSE(files.empty()) << format.name;
    EXPECT_EQ(format.several, files.begin()->first != "") << format.name;
    std::string text;
    for (const auto& [name, part] : files) text += part;
    const bool has_poses = format.name != "camera_info" && format.name != "rings";
    EXPECT_TRUE(format.name == "rings" || Contains(text, "t_imu")) << format.name;
    EXPECT_TRUE(!has_poses || Contains(text, "p_")) << format.name;
    CalibrationResult none;
    none.imu_frame_id = "imu";
    EXPECT_TRUE(format.write(none, TreeOf(none)).empty()) << format.name;
  }
}

TEST(ExportFormats, OpenCv) {
  const CalibrationResult result = TwoCameras();
  const std::string text = Export("opencv").at("");
  const cv::FileStorage file = Opened(text);
  for (const std::size_t i : {3, 4}) {
    const SensorResult& camera = result.sensors[i];
    const std::vector<double>& p = camera.intrinsics->parameters;
    const cv::FileNode node = file[camera.name];
    ExpectPose(Pose(node["T_imu_camera"].mat()), camera.calibration.T_imu_sensor);
    EXPECT_NEAR(static_cast<double>(node["time_offset"]), camera.calibration.time_offset, kNear);
    const cv::Mat K = node["camera_matrix"].mat();
    ExpectNear(
        {K.at<double>(0, 0), K.at<double>(1, 1), K.at<double>(0, 2), K.at<double>(1, 2), K.at<double>(0, 1)},
        {p[0], p[1], p[2], p[3], 0.0});
    const cv::Mat d = node["distortion_coefficients"].mat();
    ExpectNear(std::vector<double>(d.begin<double>(), d.end<double>()), {p.begin() + 4, p.end()});
    EXPECT_EQ(static_cast<int>(node["image_width"]), camera.intrinsics->width);
  }
  const cv::FileNode pair = file["cam_front_to_cam_rear"];
  cv::Mat T;
  cv::hconcat(pair["R"].mat(), pair["T"].mat(), T);
  ExpectPose(Pose(T), result.sensors[4].calibration.T_imu_sensor.Inverse() *
                          result.sensors[3].calibration.T_imu_sensor);
}

// OpenVINS reads by cv::FileStorage.
TEST(ExportFormats, KalibrAndOpenVins) {
  const CalibrationResult result = TwoCameras();
  const cv::FileStorage openvins = Opened(Export("openvins").at(""));
  const YAML::Node kalibr = YAML::Load(Export("kalibr").at(""));
  for (int i = 0; i < 2; ++i) {
    const std::string name = "cam" + std::to_string(i);
    const SensorResult& camera = result.sensors[3 + i];
    const std::vector<double>& p = camera.intrinsics->parameters;
    cv::Mat T(4, 4, CV_64F), T_kalibr(4, 4, CV_64F);
    for (int k = 0; k < 16; ++k) {
      T.at<double>(k / 4, k % 4) = static_cast<double>(openvins[name]["T_cam_imu"][k / 4][k % 4]);
      T_kalibr.at<double>(k / 4, k % 4) = kalibr[name]["T_cam_imu"][k / 4][k % 4].as<double>();
    }
    ExpectPose(Pose(T), camera.calibration.T_imu_sensor.Inverse());
    ExpectPose(Pose(T_kalibr), camera.calibration.T_imu_sensor.Inverse());
    EXPECT_NEAR(static_cast<double>(openvins[name]["timeshift_cam_imu"]), camera.calibration.time_offset,
                kNear);
    EXPECT_NEAR(kalibr[name]["timeshift_cam_imu"].as<double>(), camera.calibration.time_offset, kNear);
    ExpectNear(kalibr[name]["intrinsics"].as<std::vector<double>>(), {p.begin(), p.begin() + 4});
    ExpectNear(kalibr[name]["distortion_coeffs"].as<std::vector<double>>(), {p.begin() + 4, p.begin() + 8});
    EXPECT_EQ(static_cast<std::string>(openvins[name]["distortion_model"]),
              i == 0 ? "equidistant" : "radtan");
  }
}

TEST(ExportFormats, VinsFusion) {
  const CalibrationResult result = TwoCameras();
  const std::map<std::string, std::string> files = Export("vins_fusion");
  const cv::FileStorage main = Opened(files.at("vins_fusion.yaml"));
  ExpectPose(Pose(main["body_T_cam0"].mat()), result.sensors[3].calibration.T_imu_sensor);
  ExpectPose(Pose(main["body_T_cam1"].mat()), result.sensors[4].calibration.T_imu_sensor);
  EXPECT_NEAR(static_cast<double>(main["td"]), result.sensors[3].calibration.time_offset, kNear);
  EXPECT_EQ(static_cast<std::string>(main["cam1_calib"]), "cam_rear.yaml");
  const cv::FileStorage fisheye = Opened(files.at("cam_front.yaml")),
                        pinhole = Opened(files.at("cam_rear.yaml"));
  EXPECT_EQ(static_cast<std::string>(fisheye["model_type"]), "KANNALA_BRANDT");
  EXPECT_EQ(static_cast<std::string>(pinhole["model_type"]), "PINHOLE");
  const std::vector<double>& f = result.sensors[3].intrinsics->parameters;
  const std::vector<double>& p = result.sensors[4].intrinsics->parameters;
  const auto number = [](const cv::FileStorage& file, const char* of, const char* name) {
    return static_cast<double>(file[of][name]);
  };
  EXPECT_NEAR(number(fisheye, "projection_parameters", "k2"), f[4], kNear);
  EXPECT_NEAR(number(fisheye, "projection_parameters", "mv"), f[1], kNear);
  EXPECT_NEAR(number(fisheye, "projection_parameters", "u0"), f[2], kNear);
  EXPECT_NEAR(number(pinhole, "projection_parameters", "cy"), p[3], kNear);
  EXPECT_NEAR(number(pinhole, "distortion_parameters", "p1"), p[6], kNear);
  EXPECT_EQ(static_cast<int>(pinhole["image_height"]), 480);
}

TEST(ExportFormats, FastLioAndLioSam) {
  const CalibrationResult result = TwoCameras();
  const std::map<std::string, std::string> fast_lio = Export("fast_lio"), lio_sam = Export("lio_sam");
  ASSERT_EQ(fast_lio.size(), 3u);
  ASSERT_EQ(lio_sam.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    const SensorResult& lidar = result.sensors[i];
    const YAML::Node of_fast_lio = YAML::Load(fast_lio.at(lidar.name + ".yaml"));
    ExpectPose(Pose(of_fast_lio["mapping"]["extrinsic_R"], of_fast_lio["mapping"]["extrinsic_T"]),
               lidar.calibration.T_imu_sensor);
    EXPECT_NEAR(of_fast_lio["common"]["time_offset_lidar_to_imu"].as<double>(), lidar.calibration.time_offset,
                kNear);
    const YAML::Node of_lio_sam = YAML::Load(lio_sam.at(lidar.name + ".yaml"))["lio_sam"];
    ExpectPose(Pose(of_lio_sam["extrinsicRot"], of_lio_sam["extrinsicTrans"]),
               lidar.calibration.T_imu_sensor.Inverse());
  }
}

TEST(ExportFormats, FastLivo2) {
  const CalibrationResult result = TwoCameras();
  const std::map<std::string, std::string> files = Export("fast_livo2");
  EXPECT_EQ(files.size(), 3u * 2u + 2u);
  const SensorResult& lidar = result.sensors[1];
  const SensorResult& camera = result.sensors[4];
  const YAML::Node pair = YAML::Load(files.at("left_lidar_cam_rear.yaml"));
  const YAML::Node extrinsics = pair["extrin_calib"];
  ExpectPose(Pose(extrinsics["extrinsic_R"], extrinsics["extrinsic_T"]), lidar.calibration.T_imu_sensor);
  ExpectPose(Pose(extrinsics["Rcl"], extrinsics["Pcl"]),
             camera.calibration.T_imu_sensor.Inverse() * lidar.calibration.T_imu_sensor);
  EXPECT_NEAR(pair["time_offset"]["img_time_offset"].as<double>(), camera.calibration.time_offset, kNear);
  EXPECT_NEAR(pair["time_offset"]["lidar_time_offset"].as<double>(), lidar.calibration.time_offset, kNear);
  const YAML::Node pinhole = YAML::Load(files.at("camera_cam_rear.yaml"));
  EXPECT_NEAR(pinhole["cam_d2"].as<double>(), camera.intrinsics->parameters[6], kNear);
  EXPECT_NEAR(pinhole["cam_cx"].as<double>(), camera.intrinsics->parameters[2], kNear);
  EXPECT_EQ(YAML::Load(files.at("camera_cam_front.yaml"))["cam_model"].as<std::string>(),
            "EquidistantCamera");
}

TEST(ExportFormats, Autoware) {
  const CalibrationResult result = TwoCameras();
  const YAML::Node frames = YAML::Load(Export("autoware").at(""))["imu_link"];
  ASSERT_EQ(frames.size(), result.sensors.size());
  for (const SensorResult& sensor : result.sensors) {
    const YAML::Node frame = frames[sensor.frame_id];
    const auto number = [&](const char* name) { return frame[name].as<double>(); };
    ExpectPose({FromRollPitchYaw({number("roll"), number("pitch"), number("yaw")}),
                {number("x"), number("y"), number("z")}},
               sensor.calibration.T_imu_sensor);
  }
}

TEST(ExportFormats, IsaacHasACamerasOpticalFrameBelowItsBody) {
  CalibrationResult result = TwoCameras();
  result.sensors[4].frame_id = "cam_rear_optical_frame";
  const std::vector<ExportedFile> files = ExportFormatNamed("isaac").write(result, TreeOf(result));
  ASSERT_EQ(files.size(), 1u);
  const TemporaryDirectory directory;
  const std::filesystem::path path = directory.Path() / "isaac_calibration.urdf";
  WriteFileAtomically(path, files.front().text);
  const RobotModel model = RobotModel::Open(path);
  for (const SensorResult& sensor : result.sensors) {
    ExpectPose(model.Pose("imu_link", sensor.frame_id).value(), sensor.calibration.T_imu_sensor);
  }
  EXPECT_EQ(model.ParentOf(result.sensors[0].frame_id), "imu_link");
  EXPECT_EQ(model.ParentOf("cam_front_link"), "cam_front_link_body");
  EXPECT_EQ(model.ParentOf("cam_rear_optical_frame"), "cam_rear");
  // x forward is where the camera looks, z up where its rows come from.
  const Eigen::Matrix3d R = model.Pose("cam_rear", "cam_rear_optical_frame")->rotation.toRotationMatrix();
  EXPECT_LT((R.col(2) - Eigen::Vector3d::UnitX()).norm(), kNear);
  EXPECT_LT((R.col(1) + Eigen::Vector3d::UnitZ()).norm(), kNear);
}

// What rosparam and Kalibr read with takes 1e-05 for a text.
TEST(ExportFormats, SmallNumbersHaveAPoint) {
  for (const char* format : {"kalibr", "fast_lio", "lio_sam", "fast_livo2", "autoware"}) {
    for (const auto& [name, text] : Export(format)) {
      EXPECT_EQ(text.find("e-"), std::string::npos) << format << " " << name;
    }
  }
}

}  // namespace
}  // namespace mlic::export_formats_test
