#include "mlic_core/evaluation/single_frames.h"

#include <gtest/gtest.h>

#include <memory>

#include "mlic_core/evaluation/sensor_colours.h"
#include "mlic_core/geometry/so3.h"
#include "support/synthetic_images.h"

namespace mlic::single_frames_test {
namespace {

constexpr TimeNs kEpoch = 1700000000000000000;
constexpr double kSpeed = 4.0;  // m/s along x

std::vector<StampedPose> Path() {
  std::vector<StampedPose> path;
  for (int k = 0; k <= 200; ++k) {
    path.push_back(
        {TimeFrom(kEpoch, 0.01 * k), {Eigen::Quaterniond::Identity(), {kSpeed * 0.01 * k, 0.0, 0.0}}});
  }
  return path;
}

bool Is(const cv::Vec3b& pixel, const cv::Scalar& colour) {
  return pixel[0] == colour[0] && pixel[1] == colour[1] && pixel[2] == colour[2];
}

// Two LiDARs of which each sees one point, 6 m to the left and 9 m ahead of where the IMU is in the middle of
// the drive; the second one measures 40 ms later, when the vehicle has driven on.
TEST(ScansFromAbove, HasEachPointAtItsOwnTime) {
  CalibrationResult calibration;
  calibration.sensors.resize(2);
  calibration.sensors[0].name = "roof";
  calibration.sensors[0].calibration = {{Eigen::Quaterniond::Identity(), {0.0, 0.0, 1.0}}, 0.0};
  calibration.sensors[1].name = "side";
  calibration.sensors[1].calibration = {{FromRollPitchYaw({0.0, 0.0, M_PI / 2.0}), {1.0, 0.0, 0.0}}, 0.0};
  Drive drive;
  drive.epoch = kEpoch;
  drive.lidars.resize(2);
  LidarPoint left, ahead;
  left.position = {0.0f, 6.0f, -1.0f};
  ahead.position = {0.0f, -static_cast<float>(8.0 - kSpeed * 0.04), 0.0f};
  ahead.time = 0.04f;
  for (const double time : {0.7, 1.0, 1.3}) {
    drive.lidars[0].scans.push_back({time, {left}});
    drive.lidars[1].scans.push_back({time, {ahead}});
  }
  const cv::Mat picture = DrawScansFromAbove(drive, {"roof", "side"}, calibration, Path());
  ASSERT_EQ(picture.size(), cv::Size(1000, 1000));
  const double scale = 1000.0 / 30.0;  // px/m
  EXPECT_TRUE(Is(picture.at<cv::Vec3b>(500, static_cast<int>(500 - 6.0 * scale)), ColourOfLidar(0)));
  EXPECT_TRUE(Is(picture.at<cv::Vec3b>(static_cast<int>(500 - 9.0 * scale), 500), ColourOfLidar(1)));
  EXPECT_TRUE(DrawScansFromAbove(drive, {"roof", "side"}, CalibrationResult(), Path()).empty());
}

SensorResult Camera(const std::string& name, double yaw) {
  Eigen::Matrix3d R_facing;  // looks along x
  R_facing << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  SensorResult camera;
  camera.name = name;
  camera.type = SensorResult::Type::kCamera;
  camera.calibration.T_imu_sensor.rotation = FromRollPitchYaw({0.0, 0.0, yaw}) * Eigen::Quaterniond(R_facing);
  camera.intrinsics =
      CameraIntrinsics{CameraModel::kPlumbBob, 320, 240, {160, 160, 160, 120, 0, 0, 0, 0, 0}};  // 90 deg
  return camera;
}

TEST(Panorama, HasEachCameraWhereItLooks) {
  CalibrationResult calibration;
  calibration.sensors = {Camera("front", 0.0), Camera("left", M_PI / 2.0)};
  Drive drive;
  drive.epoch = kEpoch;
  for (const int gray : {200, 90}) {
    drive.cameras.emplace_back();
    drive.cameras.back().images = std::make_shared<MemoryImages>(
        std::vector<cv::Mat>(20, cv::Mat(240, 320, CV_8UC1, cv::Scalar(gray))));
  }
  const cv::Mat picture = DrawPanorama(drive, {"front", "left"}, calibration, Path());
  ASSERT_EQ(picture.size(), cv::Size(1440, 420));
  const int horizon = 180;  // 45 deg below the upper edge
  EXPECT_EQ(picture.at<cv::Vec3b>(horizon, 720)[0], 200) << "ahead";
  EXPECT_EQ(picture.at<cv::Vec3b>(horizon, 360)[0], 90) << "left";
  EXPECT_EQ(picture.at<cv::Vec3b>(horizon, 1080)[0], 30) << "no camera looks to the right";
  EXPECT_TRUE(DrawPanorama(drive, {"front", "left"}, CalibrationResult(), Path()).empty());
}

}  // namespace
}  // namespace mlic::single_frames_test
