#pragma once

#include <opencv2/core/mat.hpp>
#include <string>

#include "mlic_core/ingest/image_stream.h"
#include "mlic_ros/bag/serialized_message.h"

namespace mlic {

bool IsImageType(const std::string& type);

// Of a sensor_msgs/Image or sensor_msgs/CompressedImage (JPEG or PNG); the message may be cut off.
ImageHeader ReadImageHeader(const SerializedMessage& message);

// The image with 1 or 3 (BGR) channels of 8 or 16 bits; Bayer patterns are interpolated. Throws InputError,
// one line that starts with `where`, when the message cannot be decoded.
cv::Mat DecodeImage(const SerializedMessage& message, const std::string& where);

}  // namespace mlic
