#include "mlic_ros/display/display_cameras.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

namespace mlic {
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

TEST(LandmarkColours, GoFromWhiteToRed) {
  EXPECT_EQ(ColourOfError(0.0f), 0xffffffu);
  EXPECT_EQ(ColourOfError(2.0f * kLargeReprojectionError), 0xff0000u);
}

}  // namespace
}  // namespace mlic
