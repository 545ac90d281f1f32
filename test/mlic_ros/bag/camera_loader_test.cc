#include <gtest/gtest.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <unistd.h>

#include <algorithm>
#include <iterator>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "mlic_core/common/parallel.h"
#include "mlic_core/sensors/sensor_problem.h"
#include "mlic_ros/bag/bag_loader.h"
#include "support/test_bags.h"

namespace mlic::camera_loader_test {
namespace {

namespace fs = std::filesystem;

constexpr int kWidth = 64, kHeight = 48, kImages = 30;
constexpr TimeNs kCameraDelay = 7'000'000;

struct NoProgress : ProgressSink {
  void OnProgress(const std::string&, double) override {}
};

// Smooth colours, so that Bayer interpolation, chroma of half resolution and JPEG change them little; blue
// holds the image's index.
cv::Mat TestImage(int index) {
  cv::Mat image(kHeight, kWidth, CV_8UC3);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      image.at<cv::Vec3b>(y, x) =
          cv::Vec3b(static_cast<std::uint8_t>(20 + 5 * index), static_cast<std::uint8_t>(40 + 2 * x),
                    static_cast<std::uint8_t>(60 + 3 * y));
    }
  }
  return image;
}

// `pixels` as they are, with padding at the end of each row.
sensor_msgs::Image MakeImage(const cv::Mat& pixels, const std::string& encoding, int index) {
  sensor_msgs::Image message;
  message.header.stamp = RosTimeAt(kBagStart + kCameraDelay + TimeNs{index} * 100'000'000);
  message.header.frame_id = "camera_frame";
  message.width = static_cast<std::uint32_t>(pixels.cols);
  message.height = static_cast<std::uint32_t>(pixels.rows);
  message.encoding = encoding;
  const std::size_t row = pixels.cols * pixels.elemSize();
  message.step = static_cast<std::uint32_t>(row + 6);
  message.data.assign(message.step * message.height, 255);
  for (int y = 0; y < pixels.rows; ++y)
    std::memcpy(message.data.data() + y * message.step, pixels.ptr(y), row);
  return message;
}

sensor_msgs::CompressedImage Compressed(int index, const std::string& extension, const std::string& format) {
  sensor_msgs::CompressedImage message;
  message.header = MakeImage(TestImage(index), "bgr8", index).header;
  message.format = format;
  cv::imencode(extension, TestImage(index), message.data);
  return message;
}

// The pixels under a Bayer filter whose first rows' colours are named, "rggb" and the like.
cv::Mat Mosaic(const cv::Mat& image, const std::string& pattern) {
  cv::Mat mosaic(image.size(), CV_8UC1);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const char colour = pattern[static_cast<std::size_t>(2 * (y % 2) + x % 2)];
      const int channel = colour == 'b' ? 0 : colour == 'g' ? 1 : 2;
      mosaic.at<std::uint8_t>(y, x) = image.at<cv::Vec3b>(y, x)[channel];
    }
  }
  return mosaic;
}

// Full-range BT.601 as OpenCV has it, chroma shared by two pixels; order: U Y V Y.
cv::Mat Uyvy(const cv::Mat& image) {
  cv::Mat result(image.size(), CV_8UC2);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const cv::Vec3b& p = image.at<cv::Vec3b>(y, x);
      const double luma = 16.0 + 0.257 * p[2] + 0.504 * p[1] + 0.098 * p[0];
      const double u = 128.0 - 0.148 * p[2] - 0.291 * p[1] + 0.439 * p[0];
      const double v = 128.0 + 0.439 * p[2] - 0.368 * p[1] - 0.071 * p[0];
      result.at<cv::Vec2b>(y, x) = cv::Vec2b(cv::saturate_cast<std::uint8_t>(x % 2 == 0 ? u : v),
                                             cv::saturate_cast<std::uint8_t>(luma));
    }
  }
  return result;
}

// Both bytes of each pixel exchanged: Y U Y V of U Y V Y.
cv::Mat Swapped(const cv::Mat& image) {
  cv::Mat swapped(image.size(), CV_8UC2);
  cv::mixChannels(image, swapped, {0, 1, 1, 0});
  return swapped;
}

// The values of a sensor of 12 bits.
cv::Mat Wide(const cv::Mat& image) {
  cv::Mat wide;
  image.convertTo(wide, CV_16U, 16.0);
  return wide;
}

double LargestDifference(const cv::Mat& a, const cv::Mat& b) {
  // The borders of interpolated Bayer images are extrapolated.
  const cv::Rect inside(2, 2, kWidth - 4, kHeight - 4);
  return cv::norm(a(inside), b(inside), cv::NORM_INF);
}

class CameraLoader : public ::testing::Test {
 protected:
  CameraLoader()
      : directory_(fs::temp_directory_path() / ("mlic_camera_loader_" + std::to_string(getpid()))) {
    fs::create_directories(directory_);
    recipe_.path = (directory_ / "a.bag").string();
    rig_.imu.topic = "/imu";
    rig_.cameras.resize(1);
    rig_.cameras[0].name = "camera";
    rig_.cameras[0].topic = "/image";
    options_.rig_directory = directory_;
    recipe_.with_lidar = false;
    make_ = [](int index) { return MakeImage(TestImage(index), "bgr8", index); };
  }
  ~CameraLoader() override { fs::remove_all(directory_); }

  template <typename Make>
  void Write(const Make& make) {
    recipe_.write_more = [&](rosbag::Bag& bag) {
      for (int i = 0; i < kImages; ++i) {
        bag.write("/image", RosTimeAt(kBagStart + TimeNs{i} * 100'000'000 + 40'000'000), make(i));
      }
    };
    WriteTestBag(recipe_);
  }
  Dataset Load() {
    NoProgress progress;
    report_ = {};
    return LoadDataset(rig_, {recipe_.path}, options_, report_, CancellationToken(), progress);
  }
  void ExpectError(const std::vector<std::string>& parts) {
    ExpectInputError([this] { Load(); }, parts);
  }
  void ExpectImages(const cv::Mat (*expected)(int), double tolerance) {
    const Dataset dataset = Load();
    const CameraRecording& camera = dataset.drives.at(0).cameras.at(0);
    EXPECT_EQ(camera.width, kWidth);
    EXPECT_EQ(camera.height, kHeight);
    ASSERT_EQ(camera.images->Count(), static_cast<std::size_t>(kImages));
    for (const int i : {0, 17, kImages - 1}) {
      const cv::Mat image = camera.images->Load(static_cast<std::size_t>(i));
      ASSERT_EQ(image.type(), expected(i).type());
      EXPECT_LE(LargestDifference(image, expected(i)), tolerance) << "image " << i;
      EXPECT_NEAR(camera.images->Time(static_cast<std::size_t>(i)), 0.007 + 0.1 * i, 1e-9);
    }
  }

  const fs::path directory_;
  TestBag recipe_;
  Rig rig_;
  LoadOptions options_;
  LoadReport report_;
  std::function<sensor_msgs::Image(int)> make_;
};

const cv::Mat Colour(int index) { return TestImage(index); }
const cv::Mat Gray(int index) {
  cv::Mat gray;
  cv::cvtColor(TestImage(index), gray, cv::COLOR_BGR2GRAY);
  return gray;
}

TEST_F(CameraLoader, ReadsEveryColourEncoding) {
  const auto converted = [](int index, int code) {
    cv::Mat image;
    cv::cvtColor(TestImage(index), image, code);
    return image;
  };
  struct Case {
    std::string encoding;
    std::function<cv::Mat(int)> pixels;
    double tolerance;
  };
  std::vector<Case> cases{{"bgr8", [](int i) { return TestImage(i); }, 0.0},
                          {"rgb8", [&](int i) { return converted(i, cv::COLOR_BGR2RGB); }, 0.0},
                          {"bgra8", [&](int i) { return converted(i, cv::COLOR_BGR2BGRA); }, 0.0},
                          {"rgba8", [&](int i) { return converted(i, cv::COLOR_BGR2RGBA); }, 0.0},
                          {"8UC4", [&](int i) { return converted(i, cv::COLOR_BGR2BGRA); }, 0.0},
                          {"yuv422", [](int i) { return Uyvy(TestImage(i)); }, 5.0},
                          {"uyvy", [](int i) { return Uyvy(TestImage(i)); }, 5.0},
                          {"yuv422_yuy2", [](int i) { return Swapped(Uyvy(TestImage(i))); }, 5.0},
                          {"yuyv", [](int i) { return Swapped(Uyvy(TestImage(i))); }, 5.0},
                          {"bgr16", [](int i) { return Wide(TestImage(i)); }, 0.0},
                          {"rgb16", [&](int i) { return Wide(converted(i, cv::COLOR_BGR2RGB)); }, 0.0}};
  for (const std::string pattern : {"rggb", "bggr", "gbrg", "grbg"}) {
    const auto mosaic = [=](int i) { return Mosaic(TestImage(i), pattern); };
    cases.push_back({"bayer_" + pattern + "8", mosaic, 4.0});
    cases.push_back({"bayer_" + pattern + "16", [=](int i) { return Wide(mosaic(i)); }, 4.0});
  }
  for (const Case& one : cases) {
    SCOPED_TRACE(one.encoding);
    Write([&](int i) { return MakeImage(one.pixels(i), one.encoding, i); });
    ExpectImages(Colour, one.tolerance);
    EXPECT_TRUE(Reported(report_.lines, "/image: 30 images of 64 x 48 (" + one.encoding + ") at 10 Hz"));
    EXPECT_EQ(WithMessageFrames(rig_, report_).cameras[0].frame_id, "camera_frame");
  }
}

TEST_F(CameraLoader, ReadsGrayOfEightAndSixteenBits) {
  Write([](int i) { return MakeImage(Gray(i), "mono8", i); });
  ExpectImages(Gray, 0.0);
  for (const bool big_endian : {false, true}) {
    Write([&](int i) {
      cv::Mat wide = Wide(Gray(i));
      for (int y = 0; big_endian && y < wide.rows; ++y) {
        for (int x = 0; x < wide.cols; ++x) {
          std::uint16_t& value = wide.at<std::uint16_t>(y, x);
          value = static_cast<std::uint16_t>(value << 8 | value >> 8);
        }
      }
      sensor_msgs::Image message = MakeImage(wide, "mono16", i);
      message.is_bigendian = big_endian ? 1 : 0;
      return message;
    });
    ExpectImages(Gray, 0.0);
  }
}

TEST_F(CameraLoader, LastRowMayLackItsPadding) {
  Write([&](int i) {
    sensor_msgs::Image message = make_(i);
    message.data.resize(message.data.size() - 6);
    return message;
  });
  ExpectImages(Colour, 0.0);
}

TEST_F(CameraLoader, ReadsCompressedImages) {
  Write([&](int i) { return Compressed(i, ".png", "bgr8; png compressed bgr8"); });
  ExpectImages(Colour, 0.0);
  // A compressed mosaic says so in its format.
  Write([&](int i) {
    sensor_msgs::CompressedImage message;
    message.header = MakeImage(TestImage(i), "bgr8", i).header;
    message.format = "bayer_rggb8; png compressed ";
    cv::imencode(".png", Mosaic(TestImage(i), "rggb"), message.data);
    return message;
  });
  ExpectImages(Colour, 4.0);
  Write([&](int i) { return Compressed(i, ".jpg", "jpeg"); });
  ExpectImages(Colour, 8.0);
  EXPECT_TRUE(Reported(report_.lines, "64 x 48 (jpeg)"));
  Write([&](int i) {
    sensor_msgs::CompressedImage message = Compressed(i, ".jpg", "jpeg");
    if (i % 2 == 1) message.data.assign(500, 7);
    return message;
  });
  ExpectError({"/image", "15 of 30 images", "neither JPEG nor PNG"});
}

TEST_F(CameraLoader, ImagesThatCannotBeUsedAreErrors) {
  Write([&](int i) {
    sensor_msgs::Image message = make_(i);
    message.encoding = "nv12";
    return message;
  });
  ExpectError({"/image", "'nv12'", "bgr8", "enabled: false"});
  try {
    Load();
    FAIL() << "loaded";
  } catch (const UnusableSensor& problem) {
    EXPECT_FALSE(problem.Sensor().IsLidar());
    EXPECT_EQ(problem.Sensor().index, 0u);
  }
  Write([&](int i) {
    sensor_msgs::Image message = make_(i);
    message.encoding = "bgra8";
    return message;
  });
  ExpectError({"/image", "64 x 48 bgra8", "correct the driver's encoding"});
  Write([&](int i) {
    sensor_msgs::Image message = make_(i);
    message.header.stamp += ros::Duration(1000.0);
    return message;
  });
  ExpectError({"/image", "/imu", "do not overlap in time"});
  rig_.cameras[0].topic = "/imu";
  ExpectError({"/imu", "(camera)", "expected sensor_msgs/Image"});
  rig_.cameras[0].topic = "/front";
  ExpectError({"/front", "/image (sensor_msgs/Image)"});
}

TEST_F(CameraLoader, DriverThatHangsIsNoticed) {
  Write([&](int i) { return MakeImage(TestImage(std::min(i, 19)), "bgr8", i); });
  EXPECT_EQ(Load().drives.at(0).cameras.at(0).images->Count(), 20u);
  EXPECT_TRUE(Reported(report_.warnings, "topic /image: 10 of 30 images repeat the one before"));
}

TEST_F(CameraLoader, DamagedPngIsLeftOut) {
  Write([&](int i) {
    sensor_msgs::CompressedImage message = Compressed(i, ".png", "png");
    if (i == 9) message.data.resize(message.data.size() - 20);
    if (i == 12) message.data[message.data.size() / 2] ^= 1;
    return message;
  });
  const Dataset dataset = Load();
  const ImageSource& images = *dataset.drives[0].cameras[0].images;
  ASSERT_EQ(images.Count(), static_cast<std::size_t>(kImages) - 2);
  EXPECT_EQ(LargestDifference(images.Load(9), TestImage(10)), 0.0);
  EXPECT_EQ(LargestDifference(images.Load(11), TestImage(13)), 0.0);
  EXPECT_TRUE(
      Reported(report_.warnings, "topic /image: 2 images dropped; the first: a png image is damaged"));
}

TEST_F(CameraLoader, JpegWithoutPixelsIsLeftOut) {
  Write([&](int i) {
    sensor_msgs::CompressedImage message = Compressed(i, ".jpg", "jpeg");
    if (i == 9) message.data.resize(200);  // tables and size
    return message;
  });
  const Dataset dataset = Load();
  EXPECT_EQ(dataset.drives[0].cameras[0].images->Count(), static_cast<std::size_t>(kImages) - 1);
  EXPECT_TRUE(
      Reported(report_.warnings, "topic /image: 1 images dropped; the first: a jpeg image is damaged"));
}

// What only decoding shows, here Huffman tables that are none.
TEST_F(CameraLoader, ImagesThatCannotBeDecodedAreBlack) {
  Write([&](int i) {
    sensor_msgs::CompressedImage message = Compressed(i, ".jpg", "jpeg");
    constexpr std::uint8_t kTable[2] = {0xff, 0xc4};
    const auto table =
        std::search(message.data.begin(), message.data.end(), std::begin(kTable), std::end(kTable));
    if (i == 9 || i == 10) std::fill(table + 5, table + 21, 0xff);
    return message;
  });
  const Dataset dataset = Load();
  const ImageSource& images = *dataset.drives[0].cameras[0].images;
  ASSERT_EQ(images.Count(), static_cast<std::size_t>(kImages));
  const cv::Mat black = images.Load(9);
  EXPECT_EQ(black.size(), cv::Size(kWidth, kHeight));
  EXPECT_EQ(cv::countNonZero(black), 0);
  images.Load(9);
  EXPECT_EQ(images.Undecodable(), 1u);
  EXPECT_GT(cv::mean(images.Load(8))[0], 1.0);
}

TEST_F(CameraLoader, ManyThreadsLoadAtOnce) {
  Write(make_);
  const Dataset dataset = Load();
  std::vector<double> difference(300, 1.0);
  ParallelFor(difference.size(), [&](std::size_t k) {
    const std::size_t i = k * 7 % kImages;
    difference[k] =
        LargestDifference(dataset.drives[0].cameras[0].images->Load(i), TestImage(static_cast<int>(i)));
  });
  EXPECT_EQ(difference, std::vector<double>(difference.size(), 0.0));
}

TEST_F(CameraLoader, MaskIsLookedForBesideTheRigFile) {
  Write(make_);
  const cv::Mat mask(kHeight, kWidth, CV_8UC1, cv::Scalar(255));
  cv::imwrite((directory_ / "mask.png").string(), mask);
  rig_.cameras[0].mask = "mask.png";
  EXPECT_EQ(cv::countNonZero(Load().drives[0].cameras[0].mask), kHeight * kWidth);
}

}  // namespace
}  // namespace mlic::camera_loader_test
