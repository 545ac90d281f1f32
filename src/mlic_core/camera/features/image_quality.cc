#include "mlic_core/camera/features/image_quality.h"

#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>

#include "mlic_core/common/error.h"

namespace mlic {

cv::Mat ToGray(const cv::Mat& image) {
  if (image.type() == CV_8UC1) return image;
  Check(image.type() == CV_8UC3, "images are CV_8UC1 or CV_8UC3");
  cv::Mat gray;
  cv::cvtColor(image, gray, cv::COLOR_BGR2GRAY);
  return gray;
}

ImageQuality MeasureImageQuality(const cv::Mat& gray, const cv::Mat& mask) {
  std::int64_t count = 0, sum = 0, square = 0, saturated = 0, dark = 0, gradient = 0;
  for (int y = 0; y < gray.rows; y += 2) {
    const std::uint8_t* row = gray.ptr<std::uint8_t>(y);
    const std::uint8_t* allowed = mask.empty() ? nullptr : mask.ptr<std::uint8_t>(y);
    for (int x = 1; x + 1 < gray.cols; ++x) {
      if (allowed != nullptr && allowed[x] == 0) continue;
      const int value = row[x];
      ++count;
      sum += value;
      square += value * value;
      saturated += value >= 250;
      dark += value <= 5;
      const int difference = row[x + 1] - row[x - 1];
      gradient += difference * difference;
    }
  }
  ImageQuality quality;
  if (count == 0) return quality;
  const double n = static_cast<double>(count);
  const double mean = sum / n;
  quality.contrast = std::sqrt(std::max(0.0, square / n - mean * mean));
  quality.saturated_share = saturated / n;
  quality.dark_share = dark / n;
  quality.sharpness = std::sqrt(gradient / n) / std::max(1.0, mean);
  return quality;
}

}  // namespace mlic
