#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "mlic_core/common/time.h"

namespace mlic {

// What an image message says about itself, read without decoding its pixels.
struct ImageHeader {
  TimeNs stamp = 0;
  TimeNs record_time = 0;
  std::string frame_id;
  std::string encoding;  // "bgr8", "bayer_rggb8", "jpeg", ...
  int width = 0;
  int height = 0;
  std::uint64_t digest = 0;  // of its bytes; 0: not known
  std::string error;  // why its pixels cannot be decoded, one line without the topic; empty: they should be
};

// What all images of one camera have in common, by its first one that can be decoded.
struct ImageFormat {
  std::string topic;
  std::string frame_id;
  std::string encoding;
  int width = 0;
  int height = 0;
  int bits = 8;  // significant ones of each value
};

// The images of one camera, whose pixels stay where they were recorded until asked for.
struct ImageStream {
  std::vector<ImageHeader> headers;  // in order of recording
  // The pixels of headers[index], 1 or 3 (BGR) channels of 8 or 16 bits; for several threads at once. Throws
  // InputError, one line that starts with `where`, for an image that cannot be decoded.
  std::function<cv::Mat(std::size_t index, const std::string& where)> decode;
};

// The format of a topic whose first usable image is `image`, with this header.
ImageFormat FormatOf(const std::string& topic, const ImageHeader& header, const cv::Mat& image);

// Scales 16-bit values so that `bits` bits become 8; 8-bit images stay as they are.
cv::Mat ToEightBits(const cv::Mat& image, int bits);

// A camera's mask as CV_8UC1. Throws InputError, one line, when the file is no image or of another size.
cv::Mat LoadMask(const std::filesystem::path& path, const std::string& camera, int width, int height);

}  // namespace mlic
