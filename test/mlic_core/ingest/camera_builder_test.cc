#include "mlic_core/ingest/camera_builder.h"

#include <gtest/gtest.h>

#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "support/drive_messages.h"
#include "support/files.h"

namespace mlic::camera_builder_test {
namespace {

constexpr int kWidth = 64, kHeight = 48, kImages = 30;

ImageHeader Header(int index) {
  ImageHeader header;
  header.stamp = kDriveStart + TimeNs{index} * 100'000'000;
  header.record_time = header.stamp + 40'000'000;
  header.encoding = "mono8";
  header.width = kWidth;
  header.height = kHeight;
  return header;
}

// Each image is filled with its index in the stream.
ImageStream Stream() {
  ImageStream stream;
  for (int i = 0; i < kImages; ++i) stream.headers.push_back(Header(i));
  stream.decode = [](std::size_t index, const std::string&) {
    return cv::Mat(kHeight, kWidth, CV_8UC1, cv::Scalar(static_cast<double>(index)));
  };
  return stream;
}

ImageFormat Format() { return {"/image", "camera_frame", "mono8", kWidth, kHeight, 8}; }

TEST(CameraBuilder, OddImagesAreHandledAndCounted) {
  ImageStream stream = Stream();
  stream.headers[4].stamp -= 100'000'000;
  stream.headers[11].stamp += 100'000'000;
  stream.headers[12].stamp -= 100'000'000;
  stream.headers[20].stamp = 0;
  stream.headers[22].error = "an image message is cut off";
  stream.headers[24].width = 32;
  DriveNotes notes;
  const CameraRecording camera = BuildCamera(stream, Format(), kDriveStart, notes);
  const ImageSource& images = *camera.images;
  ASSERT_EQ(images.Count(), 26u);
  for (std::size_t k = 1; k < images.Count(); ++k) EXPECT_GT(images.Time(k), images.Time(k - 1));
  // The one stamped with 11's time is message 12, and it is found there.
  EXPECT_NEAR(images.Time(10), 1.1, 1e-9);
  EXPECT_EQ(images.Load(10).at<std::uint8_t>(0, 0), 12);
  for (const char* part : {"1 with a repeated stamp", "1 without a stamp", "1 of another size",
                           "1 undecodable", "out of order"}) {
    EXPECT_TRUE(IsNoted(notes.lines, part)) << part;
  }
  EXPECT_TRUE(IsNoted(notes.warnings, "3 images dropped; the first: the header stamp is zero"));
}

TEST(CameraBuilder, ImagesThatRepeatTheOneBeforeAreLeftOutAndTold) {
  ImageStream stream = Stream();
  for (std::size_t i = 0; i < stream.headers.size(); ++i) stream.headers[i].digest = i + 1;
  for (std::size_t i = 10; i < 20; ++i) stream.headers[i].digest = stream.headers[9].digest;
  DriveNotes notes;
  const CameraRecording camera = BuildCamera(stream, Format(), kDriveStart, notes);
  ASSERT_EQ(camera.images->Count(), 20u);
  EXPECT_NEAR(camera.images->Time(9), 0.9, 1e-9);
  EXPECT_NEAR(camera.images->Time(10), 2.0, 1e-9);
  EXPECT_TRUE(IsNoted(notes.warnings,
                      "topic /image: 10 of 30 images repeat the one before under a new stamp, from 1.0 s to "
                      "1.9 s"));
}

TEST(CameraBuilder, TopicsWithoutUsableImagesAreErrors) {
  DriveNotes notes;
  ImageStream stream = Stream();
  const auto error = [&] { return InputErrorOf([&] { BuildCamera(stream, Format(), kDriveStart, notes); }); };
  for (ImageHeader& header : stream.headers) header.stamp = 0;
  EXPECT_TRUE(
      Contains(error(), "topic /image: 30 of 30 images cannot be used; the first: the header stamp is zero"));
  stream.headers.clear();
  EXPECT_TRUE(Contains(error(), "topic /image: no images"));
}

TEST(CameraBuilder, SixteenBitsBecomeEight) {
  cv::Mat wide(kHeight, kWidth, CV_16UC1, cv::Scalar(16.0 * 200.0));  // of a sensor of 12 bits
  const ImageFormat format = FormatOf("/image", Header(0), wide);
  EXPECT_EQ(format.bits, 12);
  ImageStream stream = Stream();
  stream.decode = [&](std::size_t, const std::string&) { return wide; };
  DriveNotes notes;
  const cv::Mat image = BuildCamera(stream, format, kDriveStart, notes).images->Load(3);
  EXPECT_EQ(image.type(), CV_8UC1);
  EXPECT_EQ(cv::norm(image, cv::Mat(kHeight, kWidth, CV_8UC1, cv::Scalar(200.0)), cv::NORM_INF), 0.0);
}

TEST(CameraBuilder, ImagesThatTurnOutOfAnotherSizeAreBlackUnlessTheyAreMany) {
  ImageStream stream = Stream();
  stream.decode = [](std::size_t, const std::string&) { return cv::Mat(24, 32, CV_8UC1, cv::Scalar(0)); };
  DriveNotes notes;
  const CameraRecording camera = BuildCamera(stream, Format(), kDriveStart, notes);
  EXPECT_EQ(camera.images->Load(9).size(), cv::Size(kWidth, kHeight));
  const std::string error = InputErrorOf([&] {
    for (std::size_t i = 0; i < camera.images->Count(); ++i) camera.images->Load(i);
  });
  EXPECT_TRUE(Contains(error, "topic /image, image of stamp 1700000000.5"));
  EXPECT_TRUE(Contains(error, "32 x 24 pixels, expected 64 x 48"));
}

TEST(Mask, IsReadAndChecked) {
  const TemporaryDirectory directory;
  const auto error = [&](const char* name) {
    return InputErrorOf([&] { LoadMask(directory.Path() / name, "camera", kWidth, kHeight); });
  };
  cv::Mat mask = cv::Mat::ones(kHeight, kWidth, CV_8UC1) * 255;
  mask(cv::Rect(0, 30, kWidth, 18)) = 0;
  cv::imwrite((directory.Path() / "mask.png").string(), mask);
  cv::imwrite((directory.Path() / "small.png").string(), mask(cv::Rect(0, 0, 32, 24)));
  std::ofstream(directory.Path() / "text.png") << "no image";
  EXPECT_EQ(cv::countNonZero(LoadMask(directory.Path() / "mask.png", "camera", kWidth, kHeight)),
            30 * kWidth);
  for (const char* part : {"small.png", "(camera)", "32 x 24", "64 x 48"})
    EXPECT_TRUE(Contains(error("small.png"), part));
  EXPECT_TRUE(Contains(error("none.png"), "no such file; give its path relative to the rig file"));
  EXPECT_TRUE(Contains(error("text.png"), "not an image"));
}

}  // namespace
}  // namespace mlic::camera_builder_test
