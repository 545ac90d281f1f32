#include "mlic_ros/bag/image_reader.h"

#include <cv_bridge/cv_bridge.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>

#include <algorithm>
#include <boost/crc.hpp>
#include <cstring>
#include <iterator>
#include <map>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "mlic_core/common/error.h"
#include "mlic_core/common/printable.h"
#include "mlic_ros/bag/message_stream.h"

namespace mlic {
namespace {

constexpr const char* kImage = "sensor_msgs/Image";
constexpr const char* kCompressedImage = "sensor_msgs/CompressedImage";

// What cv_bridge is asked for. source: its name of the encoding, which says how pixels lie in memory; target:
// what they are converted to, empty: left as they are.
struct Reading {
  std::string source;
  std::string target;
};

// Drivers also write names that sensor_msgs/image_encodings.h does not list. cv_bridge does not know Y U Y V:
// its pixels are taken as they are and converted here.
constexpr const char* kYuy2 = "8UC2";

const Reading* FindReading(const std::string& encoding) {
  static const std::map<std::string, Reading> readings{{"mono8", {"mono8", ""}},
                                                       {"8UC1", {"8UC1", ""}},
                                                       {"mono16", {"mono16", ""}},
                                                       {"16UC1", {"16UC1", ""}},
                                                       {"bgr8", {"bgr8", ""}},
                                                       {"8UC3", {"8UC3", ""}},
                                                       {"rgb8", {"rgb8", "bgr8"}},
                                                       {"bgra8", {"bgra8", "bgr8"}},
                                                       {"8UC4", {"bgra8", "bgr8"}},
                                                       {"rgba8", {"rgba8", "bgr8"}},
                                                       {"bgr16", {"bgr16", ""}},
                                                       {"rgb16", {"rgb16", "bgr16"}},
                                                       {"bayer_rggb8", {"bayer_rggb8", "bgr8"}},
                                                       {"bayer_bggr8", {"bayer_bggr8", "bgr8"}},
                                                       {"bayer_gbrg8", {"bayer_gbrg8", "bgr8"}},
                                                       {"bayer_grbg8", {"bayer_grbg8", "bgr8"}},
                                                       {"bayer_rggb16", {"bayer_rggb16", "bgr16"}},
                                                       {"bayer_bggr16", {"bayer_bggr16", "bgr16"}},
                                                       {"bayer_gbrg16", {"bayer_gbrg16", "bgr16"}},
                                                       {"bayer_grbg16", {"bayer_grbg16", "bgr16"}},
                                                       {"yuv422", {"yuv422", "bgr8"}},
                                                       {"uyvy", {"yuv422", "bgr8"}},
                                                       {"yuv422_yuy2", {kYuy2, ""}},
                                                       {"yuyv", {kYuy2, ""}}};
  const auto found = readings.find(encoding);
  return found == readings.end() ? nullptr : &found->second;
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
    ros::serialization::IStream stream = StreamOf(message);
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

// from: standard, PNG's signature (RFC 2083, 3.1)
constexpr std::uint8_t kPng[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};

// A PNG is a row of chunks (length, name, contents, checksum of name and contents) up to the one named IEND.
bool IsWholePng(const ImageView& view) {
  constexpr std::size_t kFrame = 12;  // from: standard, length, name and checksum
  for (std::size_t at = sizeof(kPng); at + kFrame <= view.size;) {
    const std::uint8_t* chunk = view.data + at;
    const std::size_t length = BigEndian(chunk, 4);
    if (length > view.size - at - kFrame) return false;
    boost::crc_32_type checksum;
    checksum.process_bytes(chunk + 4, length + 4);
    if (checksum.checksum() != BigEndian(chunk + 8 + length, 4)) return false;
    if (std::memcmp(chunk + 4, "IEND", 4) == 0) return true;
    at += kFrame + length;
  }
  return false;
}

// Size of a PNG (its first chunk is the header) or a JPEG (in the frame segment SOF, ITU-T T.81, B.2.2).
bool FindCompressedSize(const ImageView& view, ImageHeader& header) {
  const std::uint8_t* data = view.data;
  if (view.size >= 24 && std::memcmp(data, kPng, sizeof(kPng)) == 0) {
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

// Whether a scan of the pixels begins (segment SOS, ITU-T T.81, B.2.3).
bool HasJpegScan(const ImageView& view) {
  constexpr std::uint8_t kScan[2] = {0xff, 0xda};  // from: standard
  const std::uint8_t* end = view.data + view.size;
  return std::search(view.data, end, std::begin(kScan), std::end(kScan)) != end;
}

// FNV-1a over words of 8 bytes, and the bytes that are left.
std::uint64_t DigestOf(const ImageView& view) {
  constexpr std::uint64_t kOffset = 14695981039346656037ULL, kPrime = 1099511628211ULL;  // from: standard
  constexpr std::size_t kWord = sizeof(std::uint64_t);                                   // from: structural
  std::uint64_t digest = kOffset;
  std::size_t at = 0;
  for (std::uint64_t word; at + kWord <= view.size; at += kWord) {
    std::memcpy(&word, view.data + at, kWord);
    digest = (digest ^ word) * kPrime;
  }
  for (; at < view.size; ++at) digest = (digest ^ view.data[at]) * kPrime;
  return digest;
}

// No image is packed as tightly: a size that was made up must not take memory.
bool IsPlausible(const ImageHeader& header, std::size_t bytes) {
  constexpr std::int64_t kMostSide = 65535;         // from: guard, as of raw images
  constexpr std::int64_t kPixelsOfByte = 8 * 1032;  // from: derivation, deflate's best, 8 pixels a byte
  return header.width > 0 && header.height > 0 && header.width <= kMostSide && header.height <= kMostSide &&
         std::int64_t{header.width} * header.height <= kPixelsOfByte * static_cast<std::int64_t>(bytes);
}

std::string CheckRaw(const ImageView& view) {
  const Reading* reading = FindReading(view.encoding);
  if (reading == nullptr) {
    return "encoding '" + Printable(view.encoding) +
           "' is not known; expected mono8, mono16, bgr8, rgb8, bgra8, rgba8, bayer_*8, bayer_*16 or yuv422; "
           "set the driver so, or leave the camera out by enabled: false";
  }
  const std::size_t least_step =
      view.width * static_cast<std::size_t>(CV_ELEM_SIZE(cv_bridge::getCvType(reading->source)));
  if (view.width == 0 || view.height == 0 || view.width > 65535 || view.height > 65535 ||
      view.step < least_step ||
      view.size < static_cast<std::size_t>(view.height - 1) * view.step + least_step) {
    return "the image's sizes do not fit together (" + std::to_string(view.width) + " x " +
           std::to_string(view.height) + " " + view.encoding + " in steps of " + std::to_string(view.step) +
           ", " + std::to_string(view.size) + " bytes); correct the driver's encoding, size or step";
  }
  return "";
}

// To little-endian values; cv_bridge itself makes big-endian ones of 16 bits two channels of 8 bits each.
void SwapBytes(std::size_t bytes_of_value, sensor_msgs::Image& message) {
  if (bytes_of_value != 2) return;
  for (std::size_t row = 0; row < message.data.size(); row += message.step) {
    for (std::size_t i = row; i + 1 < row + message.step; i += 2)
      std::swap(message.data[i], message.data[i + 1]);
  }
}

cv::Mat DecodeRaw(const ImageView& view) {
  const Reading& reading = *FindReading(view.encoding);
  sensor_msgs::Image message;
  message.height = view.height;
  message.width = view.width;
  // A row that has no next one may claim any step.
  message.step = view.height == 1 ? std::min(view.step, static_cast<std::uint32_t>(view.size)) : view.step;
  message.encoding = reading.source;
  // cv_bridge takes whole rows only; some drivers leave out the padding of the last one.
  const std::size_t whole = static_cast<std::size_t>(message.step) * view.height;
  message.data.assign(view.data, view.data + std::min(view.size, whole));
  message.data.resize(whole);
  if (view.big_endian) SwapBytes(CV_ELEM_SIZE1(cv_bridge::getCvType(reading.source)), message);
  const cv::Mat image = cv_bridge::toCvCopy(message, reading.target)->image;
  if (reading.source != kYuy2) return image;
  cv::Mat colour;
  cv::cvtColor(image, colour, cv::COLOR_YUV2BGR_YUY2);
  return colour;
}

// image_transport may compress a Bayer image as it is: the format then begins with its encoding.
cv::Mat DecodeCompressed(const ImageView& view) {
  sensor_msgs::CompressedImage message;
  message.data.assign(view.data, view.data + view.size);
  const cv_bridge::CvImagePtr image = cv_bridge::toCvCopy(message);
  if (image == nullptr || image->image.empty()) return {};
  const std::string encoding = view.encoding.substr(0, view.encoding.find(';'));
  const Reading* reading = FindReading(encoding);
  const bool bayer = image->image.channels() == 1 && encoding.compare(0, 6, "bayer_") == 0;
  if (bayer && reading != nullptr) {
    image->encoding = encoding;
    return cv_bridge::cvtColor(image, reading->target)->image;
  }
  return image->image.channels() == 4 ? cv_bridge::cvtColor(image, "bgr8")->image : image->image;
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
    return header;
  }
  header.digest = DigestOf(view);
  if (message.type == kImage) {
    header.encoding = view.encoding;
    header.width = static_cast<int>(view.width);
    header.height = static_cast<int>(view.height);
    header.error = CheckRaw(view);
  } else if (!FindCompressedSize(view, header)) {
    header.error =
        "a compressed image is neither JPEG nor PNG, or damaged (format '" + Printable(view.encoding) + "')";
  } else if (!IsPlausible(header, view.size)) {
    header.error = "a compressed image is damaged (" + std::to_string(header.width) + " x " +
                   std::to_string(header.height) + " in " + std::to_string(view.size) + " bytes)";
  } else if (header.encoding == "png" && !IsWholePng(view)) {
    header.error = "a png image is damaged: a checksum is wrong or its end is missing";
  } else if (header.encoding == "jpeg" && !HasJpegScan(view)) {
    header.error = "a jpeg image is damaged: it ends before its pixels";
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
  } catch (const cv_bridge::Exception& error) {
    throw InputError(where + ": an image cannot be decoded (" + error.what() + ")");
  }
  const bool usable = !image.empty() && (image.channels() == 1 || image.channels() == 3) &&
                      (image.depth() == CV_8U || image.depth() == CV_16U);
  if (!usable) throw InputError(where + ": a " + header.encoding + " image is damaged or of an unknown kind");
  return image;
}

}  // namespace mlic
