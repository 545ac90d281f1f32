#include "mlic_core/ingest/camera_builder.h"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <utility>

#include "mlic_core/common/error.h"

namespace mlic {
namespace {

constexpr double kMostBadImages =
    0.2;  // share of a topic's images; from: guard, a driver at fault spoils nearly all

struct ImageProblems {
  std::size_t no_stamp = 0, other_size = 0, undecodable = 0;
  std::string first_error;
  std::size_t All() const { return no_stamp + other_size + undecodable; }
};

// One image: what its header says of time, and where it is in the stream.
struct Entry {
  TimeNs stamp = 0;
  TimeNs record_time = 0;
  std::size_t index = 0;
  std::uint64_t digest = 0;  // as ImageHeader's
};

// The chosen images of a stream, in order of time.
class ChosenImages : public ImageSource {
 public:
  ChosenImages(ImageStream stream, ImageFormat format, TimeNs epoch, std::vector<Entry> entries)
      : decode_(std::move(stream.decode)),
        format_(std::move(format)),
        epoch_(epoch),
        entries_(std::move(entries)) {}

  std::size_t Count() const override { return entries_.size(); }
  double Time(std::size_t index) const override { return SecondsSince(epoch_, entries_.at(index).stamp); }
  cv::Mat Load(std::size_t index) const override {
    const Entry& entry = entries_.at(index);
    char stamp[64];
    std::snprintf(stamp, sizeof(stamp), ", image of stamp %.6f", 1e-9 * static_cast<double>(entry.stamp));
    std::string problem = "topic " + format_.topic + stamp;
    try {
      const cv::Mat image = ToEightBits(decode_(entry.index, problem), format_.bits);
      if (image.cols == format_.width && image.rows == format_.height) return image;
      problem += ": is of " + std::to_string(image.cols) + " x " + std::to_string(image.rows) +
                 " pixels, expected " + std::to_string(format_.width) + " x " +
                 std::to_string(format_.height) + " as its header says";
    } catch (const InputError& error) {
      problem = error.what();
    }
    if (AreTooManyWith(index)) throw InputError(problem);
    return cv::Mat::zeros(format_.height, format_.width, CV_8UC1);
  }
  std::size_t Undecodable() const override {
    const std::lock_guard<std::mutex> lock(mutex_);
    return undecodable_.size();
  }

 private:
  bool AreTooManyWith(std::size_t index) const {
    const std::lock_guard<std::mutex> lock(mutex_);
    undecodable_.insert(index);
    return static_cast<double>(undecodable_.size()) > kMostBadImages * static_cast<double>(Count());
  }

  std::function<cv::Mat(std::size_t, const std::string&)> decode_;
  ImageFormat format_;
  TimeNs epoch_;
  std::vector<Entry> entries_;
  mutable std::mutex mutex_;
  mutable std::set<std::size_t> undecodable_;
};

// The images that can be used, in order of recording.
std::vector<Entry> UsableImages(const std::vector<ImageHeader>& headers, const ImageFormat& format,
                                ImageProblems& problems) {
  const auto bad = [&](const ImageHeader& header) {
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
  std::vector<Entry> usable;
  for (std::size_t i = 0; i < headers.size(); ++i) {
    if (!bad(headers[i])) usable.push_back({headers[i].stamp, headers[i].record_time, i, headers[i].digest});
  }
  return usable;
}

void CheckImages(const ImageProblems& problems, std::size_t all, const ImageFormat& format) {
  if (all == 0) throw InputError("topic " + format.topic + ": no images in the chosen time of a drive");
  if (static_cast<double>(problems.All()) <= kMostBadImages * static_cast<double>(all)) return;
  throw InputError("topic " + format.topic + ": " + std::to_string(problems.All()) + " of " +
                   std::to_string(all) + " images cannot be used; the first: " + problems.first_error);
}

// Images with new stamps and old pixels.
struct RepeatedImages {
  std::size_t count = 0;
  double begin = 0.0, end = 0.0;  // s, the first and the last of them
};

// Drops images with the pixels of the one before: their stamps are not those of their exposure. Sensors have
// noise: only a driver that hangs, or fills in for lost ones, gives the same twice.
RepeatedImages DropRepeated(TimeNs epoch, std::vector<Entry>* entries) {
  RepeatedImages repeated;
  std::vector<Entry> kept;
  for (const Entry& entry : *entries) {
    if (kept.empty() || entry.digest == 0 || entry.digest != kept.back().digest) {
      kept.push_back(entry);
      continue;
    }
    repeated.end = SecondsSince(epoch, entry.stamp);
    if (repeated.count++ == 0) repeated.begin = repeated.end;
  }
  *entries = std::move(kept);
  return repeated;
}

void WarnOfRepeated(const ImageFormat& format, const RepeatedImages& repeated, std::size_t kept,
                    DriveNotes& notes) {
  if (repeated.count == 0) return;
  notes.warnings.push_back("topic " + format.topic + ": " + std::to_string(repeated.count) + " of " +
                           std::to_string(repeated.count + kept) +
                           " images repeat the one before under a new stamp, from " +
                           Number(repeated.begin, "%.1f") + " s to " + Number(repeated.end, "%.1f") +
                           " s; they are left out: its driver hangs or fills in, check camera and cable");
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

CameraRecording BuildCamera(ImageStream stream, const ImageFormat& format, TimeNs epoch, DriveNotes& notes) {
  ImageProblems problems;
  std::vector<Entry> entries = UsableImages(stream.headers, format, problems);
  CheckImages(problems, stream.headers.size(), format);
  const StampReport stamps = KeepSteadyPart(entries, [](const Entry& entry) {
    return MessageTimes{entry.stamp, entry.record_time};
  });
  std::stable_sort(entries.begin(), entries.end(),
                   [](const auto& a, const auto& b) { return a.stamp < b.stamp; });
  entries.erase(std::unique(entries.begin(), entries.end(),
                            [](const auto& a, const auto& b) { return a.stamp == b.stamp; }),
                entries.end());
  const RepeatedImages repeated = DropRepeated(epoch, &entries);
  NoteImages(format, entries.size(), problems, stamps, notes);
  WarnOfRepeated(format, repeated, entries.size(), notes);
  CameraRecording recording;
  recording.width = format.width;
  recording.height = format.height;
  recording.images = std::make_shared<ChosenImages>(std::move(stream), format, epoch, std::move(entries));
  return recording;
}

}  // namespace mlic
