#include "mlic_ros/bag/image_reader.h"

#include <ros/serialization.h>
#include <std_msgs/Header.h>

#include <cstring>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "mlic_core/common/error.h"

namespace mlic {
namespace {

constexpr const char* kImage = "sensor_msgs/Image";
constexpr const char* kCompressedImage = "sensor_msgs/CompressedImage";

// How the pixels of an encoding lie in memory, and the conversion to gray or BGR (-1: none).
struct PixelLayout {
  int type;
  int conversion;
};

// OpenCV names a Bayer pattern by its second row, ROS by its first.
const PixelLayout* FindLayout(const std::string& encoding) {
  static const std::map<std::string, PixelLayout> layouts{{"mono8", {CV_8UC1, -1}},
                                                          {"8UC1", {CV_8UC1, -1}},
                                                          {"mono16", {CV_16UC1, -1}},
                                                          {"16UC1", {CV_16UC1, -1}},
                                                          {"bgr8", {CV_8UC3, -1}},
                                                          {"8UC3", {CV_8UC3, -1}},
                                                          {"rgb8", {CV_8UC3, cv::COLOR_RGB2BGR}},
                                                          {"bgra8", {CV_8UC4, cv::COLOR_BGRA2BGR}},
                                                          {"8UC4", {CV_8UC4, cv::COLOR_BGRA2BGR}},
                                                          {"rgba8", {CV_8UC4, cv::COLOR_RGBA2BGR}},
                                                          {"bgr16", {CV_16UC3, -1}},
                                                          {"rgb16", {CV_16UC3, cv::COLOR_RGB2BGR}},
                                                          {"bayer_rggb8", {CV_8UC1, cv::COLOR_BayerBG2BGR}},
                                                          {"bayer_bggr8", {CV_8UC1, cv::COLOR_BayerRG2BGR}},
                                                          {"bayer_gbrg8", {CV_8UC1, cv::COLOR_BayerGR2BGR}},
                                                          {"bayer_grbg8", {CV_8UC1, cv::COLOR_BayerGB2BGR}},
                                                          {"bayer_rggb16", {CV_16UC1, cv::COLOR_BayerBG2BGR}},
                                                          {"bayer_bggr16", {CV_16UC1, cv::COLOR_BayerRG2BGR}},
                                                          {"bayer_gbrg16", {CV_16UC1, cv::COLOR_BayerGR2BGR}},
                                                          {"bayer_grbg16", {CV_16UC1, cv::COLOR_BayerGB2BGR}},
                                                          {"yuv422", {CV_8UC2, cv::COLOR_YUV2BGR_UYVY}},
                                                          {"uyvy", {CV_8UC2, cv::COLOR_YUV2BGR_UYVY}},
                                                          {"yuv422_yuy2", {CV_8UC2, cv::COLOR_YUV2BGR_YUY2}},
                                                          {"yuyv", {CV_8UC2, cv::COLOR_YUV2BGR_YUY2}}};
  const auto found = layouts.find(encoding);
  return found == layouts.end() ? nullptr : &found->second;
}

// A message's fields; data points into the message.
struct ImageView {
  std_msgs::Header header;
  std::uint32_t height = 0, width = 0, step = 0;
  std::string encoding;  // of a CompressedImage: its format
  bool big_endian = false;
  const std::uint8_t* data = nullptr;
  std::size_t size = 0;
};

// False where the message is cut off; the header is there if it could be read.
bool Parse(const SerializedMessage& message, ImageView& view) {
  try {
    ros::serialization::IStream stream(const_cast<std::uint8_t*>(message.bytes.data()),
                                       static_cast<std::uint32_t>(message.bytes.size()));
    stream.next(view.header);
    if (message.type == kImage) {
      std::uint8_t big_endian = 0;
      stream.next(view.height);
      stream.next(view.width);
      stream.next(view.encoding);
      stream.next(big_endian);
      stream.next(view.step);
      view.big_endian = big_endian != 0;
    } else {
      stream.next(view.encoding);
    }
    std::uint32_t size = 0;
    stream.next(size);
    view.data = stream.advance(size);
    view.size = size;
    return true;
  } catch (const std::exception&) {
    return false;
  }
}

std::uint32_t BigEndian(const std::uint8_t* bytes, int count) {
  std::uint32_t value = 0;
  for (int i = 0; i < count; ++i) value = value << 8 | bytes[i];
  return value;
}

// Size of a PNG (its first chunk is the header) or a JPEG (in the frame segment SOF, ITU-T T.81, B.2.2).
bool FindCompressedSize(const ImageView& view, ImageHeader& header) {
  constexpr std::uint8_t png[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  const std::uint8_t* data = view.data;
  if (view.size >= 24 && std::memcmp(data, png, sizeof(png)) == 0) {
    header.encoding = "png";
    header.width = static_cast<int>(BigEndian(data + 16, 4));
    header.height = static_cast<int>(BigEndian(data + 20, 4));
    return true;
  }
  if (view.size < 4 || data[0] != 0xff || data[1] != 0xd8) return false;
  header.encoding = "jpeg";
  for (std::size_t at = 2; at + 9 <= view.size && data[at] == 0xff;) {
    const std::uint8_t marker = data[at + 1];
    if (marker == 0xff) {  // fill byte
      ++at;
      continue;
    }
    const bool frame = marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
    if (frame) {
      header.height = static_cast<int>(BigEndian(data + at + 5, 2));
      header.width = static_cast<int>(BigEndian(data + at + 7, 2));
      return true;
    }
    at += 2 + BigEndian(data + at + 2, 2);
  }
  return false;
}

std::string CheckRaw(const ImageView& view) {
  const PixelLayout* layout = FindLayout(view.encoding);
  if (layout == nullptr) {
    return "encoding '" + view.encoding +
           "' is not known; expected mono8, mono16, bgr8, rgb8, bgra8, rgba8, bayer_*8, bayer_*16 or yuv422";
  }
  const std::size_t least_step = view.width * static_cast<std::size_t>(CV_ELEM_SIZE(layout->type));
  if (view.width == 0 || view.height == 0 || view.width > 65535 || view.height > 65535 ||
      view.step < least_step ||
      view.size < static_cast<std::size_t>(view.height - 1) * view.step + least_step) {
    return "the image's sizes do not fit together (" + std::to_string(view.width) + " x " +
           std::to_string(view.height) + " " + view.encoding + " in steps of " + std::to_string(view.step) +
           ", " + std::to_string(view.size) + " bytes)";
  }
  return "";
}

cv::Mat Convert(const cv::Mat& pixels, int conversion) {
  if (conversion < 0) return pixels.clone();
  cv::Mat image;
  cv::cvtColor(pixels, image, conversion);
  return image;
}

cv::Mat DecodeRaw(const ImageView& view) {
  const PixelLayout& layout = *FindLayout(view.encoding);
  cv::Mat pixels(static_cast<int>(view.height), static_cast<int>(view.width), layout.type,
                 const_cast<std::uint8_t*>(view.data), view.step);
  if (view.big_endian && CV_MAT_DEPTH(layout.type) == CV_16U) {
    pixels = pixels.clone();
    for (int y = 0; y < pixels.rows; ++y) {
      std::uint16_t* row = pixels.ptr<std::uint16_t>(y);
      for (int x = 0; x < pixels.cols * pixels.channels(); ++x) {
        row[x] = static_cast<std::uint16_t>(row[x] << 8 | row[x] >> 8);
      }
    }
  }
  return Convert(pixels, layout.conversion);
}

// image_transport may compress a Bayer image as it is: the format then begins with its encoding.
cv::Mat DecodeCompressed(const ImageView& view) {
  const cv::Mat bytes(1, static_cast<int>(view.size), CV_8UC1, const_cast<std::uint8_t*>(view.data));
  const cv::Mat image =
      cv::imdecode(bytes, cv::IMREAD_ANYCOLOR | cv::IMREAD_ANYDEPTH | cv::IMREAD_IGNORE_ORIENTATION);
  const PixelLayout* layout = FindLayout(view.encoding.substr(0, view.encoding.find(';')));
  const bool bayer = image.channels() == 1 && view.encoding.compare(0, 6, "bayer_") == 0;
  return bayer && layout != nullptr ? Convert(image, layout->conversion) : image;
}

}  // namespace

bool IsImageType(const std::string& type) { return type == kImage || type == kCompressedImage; }

ImageHeader ReadImageHeader(const SerializedMessage& message) {
  ImageView view;
  ImageHeader header;
  header.record_time = message.record_time;
  const bool whole = Parse(message, view);
  header.stamp = static_cast<TimeNs>(view.header.stamp.toNSec());
  header.frame_id = view.header.frame_id;
  if (!whole) {
    header.error = "an image message is cut off";
  } else if (message.type == kImage) {
    header.encoding = view.encoding;
    header.width = static_cast<int>(view.width);
    header.height = static_cast<int>(view.height);
    header.error = CheckRaw(view);
  } else if (!FindCompressedSize(view, header)) {
    header.error = "a compressed image is neither JPEG nor PNG, or damaged (format '" + view.encoding + "')";
  }
  return header;
}

cv::Mat DecodeImage(const SerializedMessage& message, const std::string& where) {
  const ImageHeader header = ReadImageHeader(message);
  if (!header.error.empty()) throw InputError(where + ": " + header.error);
  ImageView view;
  Parse(message, view);
  cv::Mat image;
  try {
    image = message.type == kImage ? DecodeRaw(view) : DecodeCompressed(view);
  } catch (const cv::Exception& error) {
    throw InputError(where + ": an image cannot be decoded (" + error.err + ")");
  }
  const bool usable = !image.empty() && (image.channels() == 1 || image.channels() == 3) &&
                      (image.depth() == CV_8U || image.depth() == CV_16U);
  if (!usable) throw InputError(where + ": a " + header.encoding + " image is damaged or of an unknown kind");
  return image;
}

}  // namespace mlic
