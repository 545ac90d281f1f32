#include "mlic_ros/bag/bag_images.h"

#include <opencv2/imgcodecs.hpp>
#include <utility>

#include "mlic_core/common/error.h"
#include "mlic_ros/bag/message_reader.h"

namespace mlic {

ImageFormat FindImageFormat(const std::vector<RawCloud>& first, const std::string& topic) {
  std::string problem = "topic " + topic + ": no images in the chosen time";
  for (const RawCloud& message : first) {
    try {
      const cv::Mat image = DecodeImage(message, "topic " + topic);
      const ImageHeader header = ReadImageHeader(message);
      return {topic, header.frame_id, header.encoding, image.cols, image.rows, SignificantBits(image)};
    } catch (const InputError& error) {
      problem = error.what();
    }
  }
  throw InputError(problem);
}

BagImages::BagImages(std::shared_ptr<const BagSet> bags, ImageFormat format, TimeNs epoch,
                     std::vector<Entry> entries)
    : bags_(std::move(bags)), format_(std::move(format)), epoch_(epoch), entries_(std::move(entries)) {}

cv::Mat BagImages::Load(std::size_t index) const {
  const Entry& entry = entries_.at(index);
  const RawCloud message = ReadMessage(*bags_, *entry.place);
  char where[64];
  std::snprintf(where, sizeof(where), ", image of stamp %.6f", 1e-9 * static_cast<double>(entry.stamp));
  const cv::Mat image = ToEightBits(DecodeImage(message, "topic " + format_.topic + where), format_.bits);
  if (image.cols != format_.width || image.rows != format_.height) {
    throw InputError("topic " + format_.topic + where + ": is of " + std::to_string(image.cols) + " x " +
                     std::to_string(image.rows) + " pixels, expected " + std::to_string(format_.width) +
                     " x " + std::to_string(format_.height) + " as the first one");
  }
  return image;
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
