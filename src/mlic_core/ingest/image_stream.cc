#include "mlic_core/ingest/image_stream.h"

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "mlic_core/common/error.h"

namespace mlic {
namespace {

// How many of the bits an image uses, by its largest value: 8 for 8-bit images, otherwise 8, 10, 12, 14
// or 16.
int SignificantBits(const cv::Mat& image) {
  if (image.depth() != CV_16U) return 8;
  double largest = 0.0;
  cv::minMaxLoc(image.reshape(1), nullptr, &largest);
  int bits = 8;
  while (bits < 16 && largest >= static_cast<double>(1 << bits)) bits += 2;
  return bits;
}

}  // namespace

ImageFormat FormatOf(const std::string& topic, const ImageHeader& header, const cv::Mat& image) {
  return {topic, header.frame_id, header.encoding, image.cols, image.rows, SignificantBits(image)};
}

cv::Mat ToEightBits(const cv::Mat& image, int bits) {
  if (image.depth() == CV_8U) return image;
  cv::Mat scaled;
  image.convertTo(scaled, CV_8U, 1.0 / static_cast<double>(1 << (bits - 8)));
  return scaled;
}

cv::Mat LoadMask(const std::filesystem::path& path, const std::string& camera, int width, int height) {
  const std::string where = "mask " + path.string() + " (" + camera + "): ";
  if (!std::filesystem::exists(path)) {
    throw InputError(where + "no such file; give its path relative to the rig file");
  }
  cv::Mat mask;
  try {
    mask = cv::imread(path.string(), cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception&) {
    mask.release();
  }
  if (mask.empty()) throw InputError(where + "not an image; expected a PNG with 0 where to ignore");
  if (mask.cols != width || mask.rows != height) {
    throw InputError(where + "is of " + std::to_string(mask.cols) + " x " + std::to_string(mask.rows) +
                     " pixels, expected the camera's " + std::to_string(width) + " x " +
                     std::to_string(height));
  }
  return mask;
}

}  // namespace mlic
