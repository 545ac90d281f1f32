#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include "mlic_core/geometry/so3.h"
#include "mlic_core/io/checkpoint/serialize.h"
#include "mlic_core/io/report/report_tables.h"
#include "mlic_core/io/result/camera_info.h"
#include "mlic_core/io/result/kalibr_camchain.h"
#include "support/files.h"
#include "support/sample_result.h"

namespace mlic::camera_export_test {
namespace {

SensorResult Camera(const std::string& name, CameraModel model, std::vector<double> parameters) {
  SensorResult camera;
  camera.name = name;
  camera.type = SensorResult::Type::kCamera;
  camera.topic = "/" + name + "/image_raw";
  camera.calibration.T_imu_sensor = {FromRollPitchYaw({-1.5, 0.1 * static_cast<double>(model), 0.7}),
                                     {0.3, 0.2, 1.0 + static_cast<double>(model)}};
  camera.calibration.time_offset = -0.0125;
  camera.intrinsics = CameraIntrinsics{model, 1280, 800, std::move(parameters)};
  return camera;
}

std::vector<double> Numbers(const YAML::Node& node) { return node.as<std::vector<double>>(); }

RigidTransform Transform(const YAML::Node& rows) {
  Eigen::Matrix3d R;
  Eigen::Vector3d t;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) R(i, k) = rows[i][k].as<double>();
    t[i] = rows[i][3].as<double>();
  }
  EXPECT_EQ(rows.size(), 4u);
  return {Eigen::Quaterniond(R), t};
}

TEST(CameraInfo, HoldsWhatRosExpects) {
  const SensorResult camera =
      Camera("cam", CameraModel::kRationalPolynomial, {500, 501, 640, 400, 1, 2, 3, 4, 5, 6, 7, 8});
  const YAML::Node info = YAML::Load(CameraInfoText(camera));
  EXPECT_EQ(info["image_width"].as<int>(), 1280);
  EXPECT_EQ(info["image_height"].as<int>(), 800);
  EXPECT_EQ(info["camera_name"].as<std::string>(), "cam");
  EXPECT_EQ(info["distortion_model"].as<std::string>(), "rational_polynomial");
  EXPECT_EQ(Numbers(info["camera_matrix"]["data"]), (std::vector<double>{500, 0, 640, 0, 501, 400, 0, 0, 1}));
  EXPECT_EQ(Numbers(info["distortion_coefficients"]["data"]), (std::vector<double>{1, 2, 3, 4, 5, 6, 7, 8}));
  EXPECT_EQ(info["distortion_coefficients"]["cols"].as<int>(), 8);
  EXPECT_EQ(Numbers(info["projection_matrix"]["data"]),
            (std::vector<double>{500, 0, 640, 0, 0, 501, 400, 0, 0, 0, 1, 0}));
  EXPECT_EQ(CameraInfoText(Camera("ds", CameraModel::kDoubleSphere, {300, 300, 640, 400, 0.1, 0.6})), "");
  EXPECT_EQ(CameraInfoText(SampleResult().sensors[0]), "");
}

TEST(KalibrCamchain, ModelsPosesAndTimeShiftFollowKalibr) {
  CalibrationResult result;
  result.sensors = {SampleResult().sensors[0],
                    Camera("front", CameraModel::kPlumbBob, {500, 501, 640, 400, 0.1, 0.2, 0.3, 0.4, 0}),
                    Camera("k3", CameraModel::kPlumbBob, {500, 501, 640, 400, 0.1, 0.2, 0.3, 0.4, 0.5}),
                    Camera("fisheye", CameraModel::kEquidistant, {300, 301, 640, 400, 1, 2, 3, 4}),
                    Camera("sphere", CameraModel::kDoubleSphere, {300, 301, 640, 400, 0.1, 0.6})};
  const std::string text = KalibrCamchainText(result, CamchainReader::kKalibr);
  EXPECT_TRUE(Contains(text, "# k3 is omitted"));
  const YAML::Node chain = YAML::Load(text);
  ASSERT_EQ(chain.size(), 3u);
  EXPECT_EQ(chain["cam0"]["camera_model"].as<std::string>(), "pinhole");
  EXPECT_EQ(chain["cam0"]["distortion_model"].as<std::string>(), "radtan");
  EXPECT_EQ(Numbers(chain["cam0"]["distortion_coeffs"]), (std::vector<double>{0.1, 0.2, 0.3, 0.4}));
  EXPECT_EQ(Numbers(chain["cam0"]["resolution"]), (std::vector<double>{1280, 800}));
  EXPECT_EQ(chain["cam0"]["rostopic"].as<std::string>(), "/front/image_raw");
  EXPECT_DOUBLE_EQ(chain["cam0"]["timeshift_cam_imu"].as<double>(), -0.0125);
  EXPECT_FALSE(chain["cam0"]["T_cn_cnm1"]);
  EXPECT_EQ(chain["cam1"]["distortion_model"].as<std::string>(), "equidistant");
  EXPECT_EQ(chain["cam2"]["camera_model"].as<std::string>(), "ds");
  EXPECT_EQ(Numbers(chain["cam2"]["intrinsics"]), (std::vector<double>{0.1, 0.6, 300, 301, 640, 400}));
  // A point of the IMU's frame lands in the same place by each camera's pose and along the chain.
  const Eigen::Vector3d p(3.0, -2.0, 1.0);
  const Eigen::Vector3d in_front = Transform(chain["cam0"]["T_cam_imu"]) * p;
  EXPECT_LT((result.sensors[1].calibration.T_imu_sensor * in_front - p).norm(), 1e-8);
  const Eigen::Vector3d in_fisheye = Transform(chain["cam1"]["T_cn_cnm1"]) * in_front;
  EXPECT_LT((result.sensors[3].calibration.T_imu_sensor * in_fisheye - p).norm(), 1e-8);
}

TEST(KalibrCamchain, ATopicIsDataWhateverItHolds) {
  for (const std::string& topic : {std::string("a: [b, \"c\"] # d"), std::string("x\ncam9: {}"),
                                   std::string("123"), std::string("no")}) {
    CalibrationResult result;
    result.sensors = {Camera("front", CameraModel::kPlumbBob, {500, 501, 640, 400, 0.1, 0.2, 0.3, 0.4, 0})};
    result.sensors[0].topic = topic;
    const std::string text = KalibrCamchainText(result, CamchainReader::kKalibr);
    const YAML::Node chain = YAML::Load(text);
    EXPECT_EQ(chain.size(), 1u);
    EXPECT_EQ(chain["cam0"]["rostopic"].as<std::string>(), topic);
    EXPECT_TRUE(Contains(text, "rostopic: \"")) << "a text for every reader";
  }
}

// The pixels are what counts, not the coefficients.
TEST(KalibrCamchain, ASmallThirdCoefficientIsFitted) {
  CalibrationResult result;
  SensorResult camera = Camera("left", CameraModel::kPlumbBob,
                               {692.8, 692.1, 641.4, 393.9, -0.0914, 0.0183, 0.0004, -0.0006, -0.0011});
  result.sensors = {camera};
  const std::string text = KalibrCamchainText(result, CamchainReader::kKalibr);
  EXPECT_TRUE(Contains(text, "fitted to the camera's plumb_bob"));
  const YAML::Node cam0 = YAML::Load(text)["cam0"];
  std::vector<double> parameters = Numbers(cam0["intrinsics"]);
  for (const double value : Numbers(cam0["distortion_coeffs"])) parameters.push_back(value);
  parameters.push_back(0.0);
  const CameraIntrinsics written{CameraModel::kPlumbBob, 1280, 800, parameters};
  double largest = 0.0;
  for (int row = 0; row < 800; row += 50) {
    for (int column = 0; column < 1280; column += 50) {
      Eigen::Vector3d bearing;
      Eigen::Vector2d pixel;
      ASSERT_TRUE(Unproject(*camera.intrinsics, Eigen::Vector2d(column, row), &bearing));
      ASSERT_TRUE(Project(written, bearing, &pixel));
      largest = std::max(largest, (pixel - Eigen::Vector2d(column, row)).norm());
    }
  }
  EXPECT_LT(largest, 0.2);
  EXPECT_GT(largest, 1e-4) << "it cannot be exact";
}

TEST(CameraReport, HeldIntrinsicsAreMarked) {
  CalibrationResult result = SampleResult();
  const std::string table = CameraTable(result);
  EXPECT_TRUE(Contains(table, "<small>fx</small>369.50<small>&plusmn; 0.110</small>"));
  EXPECT_TRUE(Contains(table, "<small>k3</small>0.000000<small>&plusmn; 0.0003000 <b>fixed</b></small>"));
  EXPECT_TRUE(Contains(table, "readout, ms</small>22.100"));
  result.sensors.resize(3);
  EXPECT_EQ(CameraTable(result), "");
}

TEST(CameraCheckpoint, IntrinsicsSurvive) {
  const CalibrationResult result = SampleResult();
  CalibrationResult copy;
  ASSERT_TRUE(FromBytes(ToBytes(result), &copy));
  EXPECT_EQ(copy.sensors[3].topic, "/cam_front/image_raw");
  EXPECT_EQ(copy.sensors[3].intrinsics_sigma, result.sensors[3].intrinsics_sigma);
  EXPECT_EQ(copy.sensors[3].intrinsics_fixed, result.sensors[3].intrinsics_fixed);
  EXPECT_EQ(copy.sensors[3].readout_sigma, result.sensors[3].readout_sigma);
}

}  // namespace
}  // namespace mlic::camera_export_test
