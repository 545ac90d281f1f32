#include "mlic_ros/bag/camera_builder.h"

#include <algorithm>
#include <string>
#include <utility>

#include "mlic_core/common/error.h"

namespace mlic {
namespace {

constexpr double kMostBadImages = 0.2;  // share of a topic's images

struct ImageProblems {
  std::size_t no_stamp = 0, other_size = 0, undecodable = 0;
  std::string first_error;
  std::size_t All() const { return no_stamp + other_size + undecodable; }
};

// Leaves out what cannot be used.
ImageProblems DropBadImages(std::vector<ReadImage>& images, const ImageFormat& format) {
  ImageProblems problems;
  const auto bad = [&](const ReadImage& image) {
    const ImageHeader& header = image.header;
    const std::size_t before = problems.All();
    std::string error;
    if (!header.error.empty()) {
      error = header.error;
      ++problems.undecodable;
    } else if (header.stamp == 0) {
      error = "the header stamp is zero; let the driver set the time of exposure";
      ++problems.no_stamp;
    } else if (header.width != format.width || header.height != format.height) {
      error = "an image is of " + std::to_string(header.width) + " x " + std::to_string(header.height) +
              " pixels, expected " + std::to_string(format.width) + " x " + std::to_string(format.height) +
              " as the first one";
      ++problems.other_size;
    }
    if (before == 0) problems.first_error = error;
    return problems.All() > before;
  };
  images.erase(std::remove_if(images.begin(), images.end(), bad), images.end());
  return problems;
}

void CheckImages(const ImageProblems& problems, std::size_t all, const ImageFormat& format) {
  if (all == 0) throw InputError("topic " + format.topic + ": no images in the chosen time of a drive");
  if (static_cast<double>(problems.All()) <= kMostBadImages * static_cast<double>(all)) return;
  throw InputError("topic " + format.topic + ": " + std::to_string(problems.All()) + " of " +
                   std::to_string(all) + " images cannot be used; the first: " + problems.first_error);
}

void NoteImages(const ImageFormat& format, std::size_t images, const ImageProblems& problems,
                const StampReport& stamps, DriveNotes& notes) {
  notes.lines.push_back("topic " + format.topic + ": " + std::to_string(images) + " images of " +
                        std::to_string(format.width) + " x " + std::to_string(format.height) + " (" +
                        format.encoding + ")" +
                        (stamps.period > 0.0 ? " at " + Number(1.0 / stamps.period) + " Hz" : "") +
                        StampText(stamps) + CountText(problems.no_stamp, "without a stamp (dropped)") +
                        CountText(problems.other_size, "of another size (dropped)") +
                        CountText(problems.undecodable, "undecodable (dropped)"));
  if (problems.All() > 0) {
    notes.warnings.push_back("topic " + format.topic + ": " + std::to_string(problems.All()) +
                             " images dropped; the first: " + problems.first_error);
  }
  AddWarnings(format.topic, stamps, notes);
}

}  // namespace

CameraRecording BuildCamera(std::vector<ReadImage> images, const ImageFormat& format,
                            const std::shared_ptr<const BagSet>& bags, TimeNs epoch, DriveNotes& notes) {
  const std::size_t all = images.size();
  const ImageProblems problems = DropBadImages(images, format);
  CheckImages(problems, all, format);
  const StampReport stamps = KeepSteadyPart(images, [](const ReadImage& image) {
    return MessageTimes{image.header.stamp, image.header.record_time};
  });
  std::vector<BagImages::Entry> entries;
  for (const ReadImage& image : images) entries.push_back({image.header.stamp, image.place});
  std::stable_sort(entries.begin(), entries.end(),
                   [](const auto& a, const auto& b) { return a.stamp < b.stamp; });
  entries.erase(std::unique(entries.begin(), entries.end(),
                            [](const auto& a, const auto& b) { return a.stamp == b.stamp; }),
                entries.end());
  NoteImages(format, entries.size(), problems, stamps, notes);
  CameraRecording recording;
  recording.width = format.width;
  recording.height = format.height;
  recording.images = std::make_shared<BagImages>(bags, format, epoch, std::move(entries));
  return recording;
}

}  // namespace mlic
