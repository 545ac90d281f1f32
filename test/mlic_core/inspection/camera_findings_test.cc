#include "mlic_core/inspection/camera_findings.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "mlic_core/inspection/find_finding.h"

namespace mlic::camera_findings_test {
namespace {

constexpr TimeNs kBegin = 1'700'000'000'000'000'000;

// Tiles of random gray under a lens that resolves its pixels.
cv::Mat Scene(int seed) {
  cv::Mat coarse(60, 80, CV_8UC1), image;
  cv::theRNG().state = static_cast<std::uint64_t>(seed) + 1;
  cv::randu(coarse, 20, 230);
  cv::resize(coarse, image, cv::Size(640, 480), 0, 0, cv::INTER_NEAREST);
  cv::GaussianBlur(image, image, cv::Size(), 0.5);
  return image;
}

template <typename Change>
CameraSurvey Survey(const Change& change) {
  CameraSurvey camera;
  camera.config.name = "camera";
  camera.config.topic = "/camera/image_raw";
  camera.config.fov_deg = 90.0;
  for (int i = 0; i < 20; ++i) {
    camera.samples.push_back(MeasureImage(change(Scene(i), i)));
    camera.samples.back().record = TimeFrom(kBegin, 2.0 * i);
    camera.samples.back().encoding = "mono8";
  }
  return camera;
}

CameraSurvey Sound() {
  return Survey([](const cv::Mat& image, int) { return image; });
}

Finding Camera(const CameraSurvey& camera, const std::string& check) {
  return FindingOf(CameraFindings(camera, kBegin, true), check);
}

TEST(CameraFindings, PassASoundCamera) {
  for (const Finding& finding : CameraFindings(Sound(), kBegin, true))
    EXPECT_EQ(finding.grade, Grade::kPass) << FindingLine(finding);
}

TEST(CameraFindings, TellBlur) {
  const CameraSurvey camera = Survey([](const cv::Mat& image, int i) {
    cv::Mat blurred = image;
    if (i >= 10) cv::GaussianBlur(image, blurred, cv::Size(), 2.5);
    return blurred;
  });
  EXPECT_EQ(Camera(camera, "blur").grade, Grade::kWarn);
  EXPECT_NE(Camera(camera, "blur").measured.find("10 of 20"), std::string::npos)
      << Camera(camera, "blur").measured;
  EXPECT_NE(Camera(camera, "blur").measured.find("at 20.00 s"), std::string::npos);
}

TEST(CameraFindings, TellExposure) {
  const std::string check = "dark, overexposed or without structure";
  for (const double offset : {-1000.0, 1000.0}) {
    const CameraSurvey camera = Survey([&](const cv::Mat& image, int) { return cv::Mat(image + offset); });
    EXPECT_EQ(Camera(camera, check).grade, Grade::kFail);
  }
}

TEST(CameraFindings, TellFrozenImages) {
  const CameraSurvey camera = Survey([](const cv::Mat& image, int i) { return i < 14 ? image : Scene(14); });
  EXPECT_EQ(Camera(camera, "frozen images").grade, Grade::kWarn);
  EXPECT_EQ(FindingOf(CameraFindings(camera, kBegin, false), "frozen images").grade, Grade::kPass);
}

TEST(CameraFindings, TellMixedAndBrokenImages) {
  CameraSurvey camera = Sound();
  camera.samples[7].encoding = "bgr8";
  EXPECT_EQ(Camera(camera, "size and encoding").grade, Grade::kFail);
  camera.undecodable = 10;
  EXPECT_EQ(Camera(camera, "decoding").grade, Grade::kWarn);
  camera.config.topic = "/camera/image_rect_color";
  EXPECT_EQ(Camera(camera, "raw images").grade, Grade::kWarn);
}

TEST(CameraFindings, CompareTheLensWithTheImages) {
  const std::string check = "lens in the rig file";
  CameraSurvey camera = Sound();
  camera.config.fov_deg = 190.0;  // of a pinhole
  EXPECT_EQ(Camera(camera, check).grade, Grade::kFail);
  camera.config.intrinsics = {500.0, 500.0, 320.0, 240.0, 0.0, 0.0, 0.0, 0.0, 0.0};
  EXPECT_EQ(Camera(camera, check).grade, Grade::kPass);
  camera.config.intrinsics = {900.0, 900.0, 640.0, 480.0, 0.0, 0.0, 0.0, 0.0, 0.0};
  EXPECT_EQ(Camera(camera, check).grade, Grade::kFail);
}

}  // namespace
}  // namespace mlic::camera_findings_test
