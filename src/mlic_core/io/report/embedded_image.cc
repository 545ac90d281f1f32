#include "mlic_core/io/report/embedded_image.h"

#include <cstdint>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "mlic_core/common/error.h"

namespace mlic {
namespace {

std::string Encode(const cv::Mat& picture, const std::string& extension, const std::vector<int>& settings) {
  std::vector<unsigned char> bytes;
  Check(cv::imencode(extension, picture, bytes, settings), "OpenCV cannot encode a picture of the report");
  return EncodeBase64(std::string(bytes.begin(), bytes.end()));
}

}  // namespace

std::string EmbedPng(const cv::Mat& picture) {
  constexpr int kSmallest = 9;  // from: standard, zlib's highest level
  return "data:image/png;base64," + Encode(picture, ".png",
                                           {cv::IMWRITE_PNG_COMPRESSION, kSmallest, cv::IMWRITE_PNG_STRATEGY,
                                            cv::IMWRITE_PNG_STRATEGY_DEFAULT});
}

std::string EmbedJpeg(const cv::Mat& picture, int quality) {
  return "data:image/jpeg;base64," + Encode(picture, ".jpg", {cv::IMWRITE_JPEG_QUALITY, quality});
}

std::string EncodeBase64(const std::string& bytes) {
  static const char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t value = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      value = (value << 8) | (i + k < bytes.size() ? static_cast<std::uint8_t>(bytes[i + k]) : 0u);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      text += i + k <= bytes.size() ? kDigits[(value >> (18 - 6 * k)) & 63u] : '=';
    }
  }
  return text;
}

}  // namespace mlic
