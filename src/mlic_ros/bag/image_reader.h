#pragma once

#include <opencv2/core/mat.hpp>
#include <string>

#include "mlic_ros/bag/cloud_decoder.h"

namespace mlic {

// What an image message says about itself, read without decoding its pixels.
struct ImageHeader {
  TimeNs stamp = 0;
  TimeNs record_time = 0;
  std::string frame_id;
  std::string encoding;  // "bgr8", "bayer_rggb8", "jpeg", ...
  int width = 0;
  int height = 0;
  std::string error;  // why its pixels cannot be decoded, one line without the topic; empty: they should be
};

bool IsImageType(const std::string& type);

// Of a sensor_msgs/Image or sensor_msgs/CompressedImage (JPEG or PNG); the message may be cut off.
ImageHeader ReadImageHeader(const RawCloud& message);

// The image with 1 or 3 (BGR) channels of 8 or 16 bits; Bayer patterns are interpolated. Throws InputError,
// one line that starts with `where`, when the message cannot be decoded.
cv::Mat DecodeImage(const RawCloud& message, const std::string& where);

// How many of the bits an image uses, by its largest value: 8 for 8-bit images, otherwise 8, 10, 12, 14
// or 16.
int SignificantBits(const cv::Mat& image);

// Scales 16-bit values so that `bits` bits become 8; 8-bit images stay as they are.
cv::Mat ToEightBits(const cv::Mat& image, int bits);

}  // namespace mlic
