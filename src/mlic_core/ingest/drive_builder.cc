#include "mlic_core/ingest/drive_builder.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "mlic_core/common/error.h"
#include "mlic_core/imu/vibration.h"
#include "mlic_core/ingest/camera_builder.h"
#include "mlic_core/ingest/drive_notes.h"
#include "mlic_core/ingest/even_stamps.h"
#include "mlic_core/lidar/own_body.h"
#include "mlic_core/lidar/scan_joining.h"
#include "mlic_core/sensors/sensor_problem.h"

namespace mlic {
namespace {

constexpr double kMostBadTimes =
    0.2;  // share of a topic's scans; from: guard, a driver at fault spoils nearly all

// Of the samples: with less left a drive tells little. from: guard, an axis that failed is frozen for all of
// it.
constexpr double kMostFrozenAxis = 0.5;

// Throws InputError where an axis is frozen for most of the drive.
void ReportFrozenAxes(const std::string& topic, const ImuCounts& counts, std::size_t samples,
                      DriveNotes& notes) {
  for (int axis = 0; axis < kImuAxes; ++axis) {
    const std::size_t frozen = counts.frozen_axes[axis];
    if (frozen == 0) continue;
    const std::string what = "topic " + topic + ": " + AxisName(axis) + " repeats its reading for " +
                             std::to_string(frozen) + " of " + std::to_string(samples) +
                             " samples while other axes go on";
    if (static_cast<double>(frozen) > kMostFrozenAxis * static_cast<double>(samples)) {
      throw InputError(what +
                       ", expected measurements of all six; the sensor is broken or its driver fills " +
                       "the axis in: use another IMU, or a part of the drive where it works");
    }
    notes.warnings.push_back(what + "; they are dropped as not measured");
  }
}

std::vector<ImuSample> BuildImu(std::vector<StampedImu> samples, const std::string& topic, TimeNs& epoch,
                                DriveNotes& notes) {
  const StampReport report = KeepSteadyPart(samples, [](const StampedImu& sample) {
    return MessageTimes{sample.stamp, sample.record};
  });
  const std::optional<EvenStamps> even = FindEvenStamps(samples);
  for (std::size_t k = 0; even && k < samples.size(); ++k) samples[k].stamp = even->stamps[k];
  const std::size_t recorded = samples.size();
  const ImuCounts counts = CleanImu(samples, topic);
  ReportFrozenAxes(topic, counts, recorded, notes);
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
                        CountText(counts.not_finite, "not finite (dropped)") +
                        CountText(counts.frozen, "frozen (dropped)") +
                        CountText(counts.saturated, "saturated (dropped)") +
                        CountText(counts.spikes, "spikes (dropped)") + StampText(report));
  if (counts.not_finite > 0) {
    notes.warnings.push_back("topic " + topic + ": " + std::to_string(counts.not_finite) +
                             " IMU samples hold NaN or infinite values; dropped");
  }
  if (counts.frozen > 0) {
    notes.warnings.push_back("topic " + topic + ": " + std::to_string(counts.frozen) +
                             " IMU samples repeat the one before exactly, for a tenth of a second or longer; "
                             "dropped as not measured");
  }
  if (counts.saturated > 0) {
    notes.warnings.push_back("topic " + topic + ": " + std::to_string(counts.saturated) +
                             " IMU samples are at the end of the sensor's range; dropped, set a wider range");
  }
  if (counts.spikes > 0) {
    notes.warnings.push_back("topic " + topic + ": " + std::to_string(counts.spikes) +
                             " IMU samples are far off both their neighbours; dropped as spikes, check the "
                             "connection to the IMU");
  }
  if (report.longest_gap > 10.0 * report.period) {
    notes.warnings.push_back("topic " + topic + ": a gap of " + Number(report.longest_gap) +
                             " s in the IMU data");
  }
  if (even) {
    notes.lines.push_back("topic " + topic + ": stamps are up to " + Number(1e3 * even->latest, "%.1f") +
                          " ms late (" + Number(1e3 * even->late, "%.2f") +
                          " ms rms), as of arrival: the IMU measures evenly, and its samples stand so");
  }
  AddWarnings(topic, report, notes);
  std::optional<FilteredImu> filtered = WithoutVibration(imu);
  if (!filtered) return imu;
  notes.lines.push_back("topic " + topic + ": vibration (" + Number(filtered->specific_force) + " m/s^2, " +
                        Number(filtered->angular_velocity, "%.2g") + " rad/s rms above " +
                        Number(filtered->above) + " Hz) is filtered out, which leaves " +
                        std::to_string(filtered->samples.size()) + " samples");
  if (filtered->turns_above > 0.0) {
    notes.lines.push_back("topic " + topic + ": turning above " + Number(filtered->turns_above) + " Hz (" +
                          Number(filtered->fast_turns, "%.2g") +
                          " rad/s rms), which no trajectory follows, is filtered out");
  }
  return std::move(filtered->samples);
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

// Where each scan has another fault, none of which is in all of them.
[[noreturn]] void ThrowNoScans(const ScanProblems& problems, const LidarFormat& format) {
  throw InputError(
      "topic " + format.topic + ": no scan can be used: " + std::to_string(problems.no_returns) +
      " without returns, " + std::to_string(problems.malformed) + " malformed and " +
      std::to_string(problems.bad_times) +
      " with unfitting point times; mend the driver and record again, or leave the LiDAR out of the rig");
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
  if (scans.empty()) ThrowNoScans(problems, format);
  const StampReport stamps = KeepSteadyPart(scans, [](const ReadScan& scan) {
    return MessageTimes{scan.stamp, scan.record_time};
  });
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
  const std::size_t pieces = JoinShortScans(&recording);
  if (pieces > 1) {
    notes.lines.push_back("topic " + format.topic + ": " + std::to_string(pieces) +
                          " messages each are taken as one scan of " + Number(recording.scan_period) + " s");
  }
  const std::size_t own = RemoveOwnBody(&recording);
  if (own > 0) {
    notes.lines.push_back("topic " + format.topic + ": " + std::to_string(own) +
                          " points left out that never move in the sensor's frame: the own vehicle");
  }
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
                 DriveNotes& notes) {
  Drive drive;
  drive.imu = BuildImu(std::move(messages.imu), imu_topic, drive.epoch, notes);
  for (std::size_t i = 0; i < lidar_formats.size(); ++i) {
    OfSensor(LidarId(i), [&] {
      drive.lidars.push_back(BuildLidar(std::move(messages.lidars[i]), lidar_formats[i], drive.epoch, notes));
      const LidarRecording& lidar = drive.lidars.back();
      CheckOverlap(drive, lidar.scans.front().time, lidar.scans.back().time + lidar.scan_period, imu_topic,
                   lidar_formats[i].topic);
    });
  }
  for (std::size_t i = 0; i < image_formats.size(); ++i) {
    OfSensor(CameraId(i), [&] {
      const ImageFormat& format = image_formats[i];
      drive.cameras.push_back(BuildCamera(std::move(messages.cameras[i]), format, drive.epoch, notes));
      const ImageSource& images = *drive.cameras.back().images;
      CheckOverlap(drive, images.Time(0), images.Time(images.Count() - 1), imu_topic, format.topic);
    });
  }
  return drive;
}

}  // namespace mlic
