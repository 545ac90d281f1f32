#include "mlic_ros/display/display_cameras.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace mlic::display_cameras_test {
namespace {

int BrightPixels(const cv::Mat& picture, const cv::Rect& place) {
  cv::Mat gray;
  cv::cvtColor(picture(place), gray, cv::COLOR_BGR2GRAY);
  return cv::countNonZero(gray > 200);
}

TEST(TilePictures, EachTileCarriesItsNameAtOneHeightWhateverItsPicture) {
  const std::vector<cv::Mat> pictures{cv::Mat(400, 640, CV_8UC3, cv::Scalar::all(90)),
                                      cv::Mat(1600, 2560, CV_8UC3, cv::Scalar::all(90)),
                                      cv::Mat(100, 320, CV_8UC3, cv::Scalar::all(90))};
  const cv::Mat tiled = TilePictures(pictures, {"left", "left", ""}, 320);
  ASSERT_EQ(tiled.cols, 320);
  ASSERT_EQ(tiled.rows, 3 * 200);
  const int small = BrightPixels(tiled, {0, 100, 160, 100}), large = BrightPixels(tiled, {0, 300, 160, 100});
  EXPECT_GT(small, 100);
  EXPECT_EQ(small, large);
  EXPECT_EQ(BrightPixels(tiled, {0, 0, 320, 100}), 0) << "the upper half has the picture's own legend";
  EXPECT_EQ(BrightPixels(tiled, {0, 400, 320, 200}), 0);
}

TEST(Frustums, AreNoLongerThanASmallRig) {
  CalibrationSnapshot snapshot;
  snapshot.sensor_names = snapshot.sensor_frames = {"lidar", "camera"};
  snapshot.sensors.resize(2);
  snapshot.intrinsics.resize(1);
  CameraIntrinsics& camera = snapshot.intrinsics[0];
  camera.width = 640, camera.height = 480;
  camera.parameters = {400.0, 400.0, 320.0, 240.0, 0.0, 0.0, 0.0, 0.0, 0.0};
  const auto length = [&](double rig) {
    snapshot.sensors[1].T_imu_sensor.translation = {rig, 0.0, 0.0};
    const visualization_msgs::Marker marker = MakeFrustumMarkers(snapshot).markers.at(0);
    double longest = 0.0;
    for (const geometry_msgs::Point& p : marker.points)
      longest = std::max(longest, std::hypot(p.x, p.y, p.z));
    EXPECT_NEAR(marker.scale.x, 0.02 * longest, 1e-6);
    return longest;
  };
  EXPECT_NEAR(length(2.5), 0.5, 1e-9);
  EXPECT_NEAR(length(0.2), 0.14, 1e-9);
  EXPECT_NEAR(length(0.0), 0.1, 1e-9);
}

TEST(LandmarkColours, GoFromWhiteToRed) {
  EXPECT_EQ(ColourOfError(0.0f), 0xffffffu);
  EXPECT_EQ(ColourOfError(2.0f * kLargeReprojectionError), 0xff0000u);
}

}  // namespace
}  // namespace mlic::display_cameras_test
