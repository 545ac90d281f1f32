#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "mlic_core/sensors/images.h"
#include "mlic_ros/bag/bag_set.h"
#include "mlic_ros/bag/image_reader.h"

namespace mlic {

// Where an image lies in the bags.
using BagPlace = std::shared_ptr<const rosbag::MessageInstance>;

// What all images of one camera have in common, by its first one that can be decoded.
struct ImageFormat {
  std::string topic;
  std::string frame_id;
  std::string encoding;
  int width = 0;
  int height = 0;
  int bits = 8;  // significant ones of each value
};

// One image message, not decoded.
struct ReadImage {
  ImageHeader header;
  BagPlace place;
};

// By the first messages of a topic. Throws InputError, one line that starts with the topic, when none of them
// can be decoded.
ImageFormat FindImageFormat(const std::vector<RawCloud>& first, const std::string& topic);

// Images that stay in the bags until asked for. Reading is one at a time, decoding in parallel.
class BagImages : public ImageSource {
 public:
  struct Entry {
    TimeNs stamp = 0;
    BagPlace place;
  };
  // entries: in order of time. The bags stay open for as long as the source lives.
  BagImages(std::shared_ptr<const BagSet> bags, ImageFormat format, TimeNs epoch, std::vector<Entry> entries);

  std::size_t Count() const override { return entries_.size(); }
  double Time(std::size_t index) const override { return SecondsSince(epoch_, entries_.at(index).stamp); }
  cv::Mat Load(std::size_t index) const override;

 private:
  std::shared_ptr<const BagSet> bags_;
  ImageFormat format_;
  TimeNs epoch_;
  std::vector<Entry> entries_;
};

// A camera's mask as CV_8UC1. Throws InputError, one line, when the file is no image or of another size.
cv::Mat LoadMask(const std::filesystem::path& path, const std::string& camera, int width, int height);

}  // namespace mlic
