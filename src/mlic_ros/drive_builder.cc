#include "mlic_ros/drive_builder.h"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "mlic_core/common/error.h"
#include "mlic_ros/stamp_check.h"

namespace mlic {
namespace {

constexpr double kMostBadTimes = 0.2;   // share of a topic's scans
constexpr double kMostBadImages = 0.2;  // share of a topic's images

std::string Number(double value, const char* format = "%.4g") {
  char text[64];
  std::snprintf(text, sizeof(text), format, value);
  return text;
}

// "; 3 out of order" and the like, only where there is something to say.
std::string CountText(std::size_t count, const std::string& what) {
  return count == 0 ? "" : "; " + std::to_string(count) + " " + what;
}

std::string StampText(const StampReport& report) {
  return CountText(report.out_of_order, "out of order (sorted)") +
         CountText(report.duplicates, "with a repeated stamp (dropped)") +
         (report.missing == 0
              ? ""
              : CountText(report.missing, "missing, longest gap ") + Number(report.longest_gap) + " s");
}

void AddWarnings(const std::string& topic, const StampReport& report, DriveNotes& notes) {
  for (const std::string& warning : report.warnings)
    notes.warnings.push_back("topic " + topic + ": " + warning);
}

std::vector<ImuSample> BuildImu(std::vector<StampedImu> samples, const std::string& topic, TimeNs& epoch,
                                DriveNotes& notes) {
  std::vector<MessageTimes> times;
  for (const StampedImu& sample : samples) times.push_back({sample.stamp, sample.record});
  const StampReport report = CheckStamps(times);
  const ImuCounts counts = CleanImu(samples, topic);
  if (samples.size() < 2 || report.period <= 0.0) {
    throw InputError("topic " + topic +
                     ": only one IMU sample or all header stamps alike; expected the time of each");
  }
  epoch = samples.front().stamp;
  std::vector<ImuSample> imu;
  imu.reserve(samples.size());
  for (const StampedImu& sample : samples) {
    imu.push_back({SecondsSince(epoch, sample.stamp), sample.angular_velocity, sample.specific_force});
  }
  notes.lines.push_back("topic " + topic + ": " + std::to_string(imu.size()) + " IMU samples at " +
                        Number(1.0 / report.period) + " Hz over " + Number(imu.back().time) + " s" +
                        CountText(counts.not_finite, "not finite (dropped)") + StampText(report));
  if (counts.not_finite > 0) {
    notes.warnings.push_back("topic " + topic + ": " + std::to_string(counts.not_finite) +
                             " IMU samples hold NaN or infinite values; dropped");
  }
  if (report.longest_gap > 10.0 * report.period) {
    notes.warnings.push_back("topic " + topic + ": a gap of " + Number(report.longest_gap) +
                             " s in the IMU data");
  }
  AddWarnings(topic, report, notes);
  return imu;
}

struct ScanProblems {
  std::size_t no_returns = 0, bad_times = 0, malformed = 0;
  std::string first_error;
};

ScanProblems CountProblems(const std::vector<ReadScan>& scans) {
  ScanProblems problems;
  for (const ReadScan& scan : scans) {
    if (scan.problem == ReadScan::Problem::kNoReturns) ++problems.no_returns;
    if (scan.problem == ReadScan::Problem::kBadTimes) ++problems.bad_times;
    if (scan.problem == ReadScan::Problem::kMalformed && problems.malformed++ == 0)
      problems.first_error = scan.error;
  }
  return problems;
}

void CheckProblems(const ScanProblems& problems, std::size_t all, const LidarFormat& format) {
  if (all == 0) throw InputError("topic " + format.topic + ": no scans in the chosen time of a drive");
  if (problems.malformed == all) throw InputError(problems.first_error);
  if (problems.no_returns + problems.malformed == all) {
    throw InputError("topic " + format.topic + ": none of " + std::to_string(all) +
                     " scans has a single finite point off the origin");
  }
  if (static_cast<double>(problems.bad_times) > kMostBadTimes * static_cast<double>(all)) {
    throw InputError("topic " + format.topic + ": " + std::to_string(problems.bad_times) + " of " +
                     std::to_string(all) + " scans have point times that do not fit the rest (" +
                     DescribeTimes(format) + "); expected the same unit and reference in all scans");
  }
}

void NoteLidar(const LidarFormat& format, const LidarRecording& recording, const ScanProblems& problems,
               const ScanFilterCounts& points, const StampReport& stamps, DriveNotes& notes) {
  notes.lines.push_back("topic " + format.topic + ": " + std::to_string(recording.scans.size()) +
                        " scans at " + Number(1.0 / recording.scan_period) + " Hz, " + DescribeTimes(format) +
                        StampText(stamps) + CountText(problems.no_returns, "without returns (dropped)") +
                        CountText(problems.bad_times, "with unfitting point times (dropped)") +
                        CountText(problems.malformed, "malformed (dropped)"));
  notes.lines.push_back("topic " + format.topic + ": " + std::to_string(points.kept) + " points kept, " +
                        std::to_string(points.not_finite) + " not finite, " +
                        std::to_string(points.too_near) + " zero or too near, " +
                        std::to_string(points.too_far) + " too far, " + std::to_string(points.thinned_out) +
                        " thinned out");
  if (problems.bad_times + problems.malformed > 0) {
    notes.warnings.push_back("topic " + format.topic + ": " +
                             std::to_string(problems.bad_times + problems.malformed) +
                             " scans are malformed or have unfitting point times; dropped");
  }
  AddWarnings(format.topic, stamps, notes);
}

LidarRecording BuildLidar(std::vector<ReadScan> scans, const LidarFormat& format, TimeNs epoch,
                          DriveNotes& notes) {
  const ScanProblems problems = CountProblems(scans);
  CheckProblems(problems, scans.size(), format);
  scans.erase(std::remove_if(scans.begin(), scans.end(),
                             [](const ReadScan& scan) { return scan.problem != ReadScan::Problem::kNone; }),
              scans.end());
  std::vector<MessageTimes> times;
  for (const ReadScan& scan : scans) times.push_back({scan.stamp, scan.record_time});
  const StampReport stamps = CheckStamps(times);

  std::stable_sort(scans.begin(), scans.end(),
                   [](const ReadScan& a, const ReadScan& b) { return a.stamp < b.stamp; });
  scans.erase(std::unique(scans.begin(), scans.end(),
                          [](const ReadScan& a, const ReadScan& b) { return a.stamp == b.stamp; }),
              scans.end());
  LidarRecording recording;
  recording.scan_period = stamps.period > 0.0 ? stamps.period : format.scan_period;
  recording.point_times_from_azimuth = format.time_field.empty();
  ScanFilterCounts points;
  for (ReadScan& scan : scans) {
    points += scan.counts;
    scan.scan.time = SecondsSince(epoch, scan.start);
    recording.scans.push_back(std::move(scan.scan));
  }
  NoteLidar(format, recording, problems, points, stamps, notes);
  return recording;
}

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

CameraRecording BuildCamera(std::vector<ReadImage> images, const ImageFormat& format,
                            const std::shared_ptr<const BagSet>& bags, TimeNs epoch, DriveNotes& notes) {
  const std::size_t all = images.size();
  const ImageProblems problems = DropBadImages(images, format);
  CheckImages(problems, all, format);
  std::vector<MessageTimes> times;
  std::vector<BagImages::Entry> entries;
  for (const ReadImage& image : images) {
    times.push_back({image.header.stamp, image.header.record_time});
    entries.push_back({image.header.stamp, image.place});
  }
  const StampReport stamps = CheckStamps(times);
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

// begin, end: of the topic's messages, s since the epoch.
void CheckOverlap(const Drive& drive, double begin, double end, const std::string& imu_topic,
                  const std::string& topic) {
  if (end > drive.imu.front().time && begin < drive.imu.back().time) return;
  const auto absolute = [&](double time) {
    const TimeNs value = TimeFrom(drive.epoch, time);
    return Number(1e-9 * static_cast<double>(value), "%.3f");
  };
  throw InputError(
      "topics " + topic + " and " + imu_topic + " do not overlap in time: header stamps " + absolute(begin) +
      " to " + absolute(end) + " s against " + absolute(drive.imu.front().time) + " to " +
      absolute(drive.imu.back().time) +
      " s; set the sensors' clocks (or the drivers to stamp with the host's time) and record again");
}

}  // namespace

Drive BuildDrive(DriveMessages messages, const std::string& imu_topic,
                 const std::vector<LidarFormat>& lidar_formats, const std::vector<ImageFormat>& image_formats,
                 const std::shared_ptr<const BagSet>& bags, DriveNotes& notes) {
  Drive drive;
  drive.imu = BuildImu(std::move(messages.imu), imu_topic, drive.epoch, notes);
  for (std::size_t i = 0; i < lidar_formats.size(); ++i) {
    drive.lidars.push_back(BuildLidar(std::move(messages.lidars[i]), lidar_formats[i], drive.epoch, notes));
    const LidarRecording& lidar = drive.lidars.back();
    CheckOverlap(drive, lidar.scans.front().time, lidar.scans.back().time + lidar.scan_period, imu_topic,
                 lidar_formats[i].topic);
  }
  for (std::size_t i = 0; i < image_formats.size(); ++i) {
    const ImageFormat& format = image_formats[i];
    drive.cameras.push_back(BuildCamera(std::move(messages.cameras[i]), format, bags, drive.epoch, notes));
    const ImageSource& images = *drive.cameras.back().images;
    CheckOverlap(drive, images.Time(0), images.Time(images.Count() - 1), imu_topic, format.topic);
  }
  return drive;
}

}  // namespace mlic
