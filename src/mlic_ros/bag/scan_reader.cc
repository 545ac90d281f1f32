#include "mlic_ros/bag/scan_reader.h"

#include <algorithm>
#include <cmath>

#include "mlic_core/common/error.h"
#include "mlic_core/lidar/azimuth_time.h"

namespace mlic {
namespace {

bool HasReturn(const Eigen::Vector3f& point) { return point.allFinite() && point.squaredNorm() > 1e-6f; }

// Nothing where no point has a return and a finite time.
std::optional<PointTimeRange> TimeRangeOf(const DecodedCloud& cloud) {
  std::optional<PointTimeRange> range;
  for (std::size_t i = 0; i < cloud.positions.size(); ++i) {
    if (!HasReturn(cloud.positions[i]) || !std::isfinite(cloud.times[i])) continue;
    if (!range) range = PointTimeRange{cloud.stamp, cloud.times[i], cloud.times[i]};
    range->minimum = std::min(range->minimum, cloud.times[i]);
    range->maximum = std::max(range->maximum, cloud.times[i]);
  }
  return range;
}

std::vector<PointTimeRange> TimeRangesOf(const std::vector<RawCloud>& probe, const std::string& topic,
                                         const std::string& field) {
  std::vector<PointTimeRange> ranges;
  for (const RawCloud& raw : probe) {
    const auto range = TimeRangeOf(DecodeCloud(raw, topic, field));
    if (range) ranges.push_back(*range);
  }
  return ranges;
}

// A field that every driver setting without times leaves at one value.
bool IsConstant(const std::vector<PointTimeRange>& ranges) {
  return std::all_of(ranges.begin(), ranges.end(), [](const auto& r) { return r.minimum == r.maximum; });
}

// Sets time_field and time from the first field that fits; false when the messages have no times at all.
bool FindTimeField(const std::vector<RawCloud>& probe, LidarFormat& format) {
  std::string first_error;
  for (const std::string& field : TimeFields(probe.front())) {
    const std::vector<PointTimeRange> ranges = TimeRangesOf(probe, format.topic, field);
    if (ranges.empty() || IsConstant(ranges)) continue;
    try {
      const std::string where = "topic " + format.topic + ", point time field '" + field + "'";
      format.time = FindPointTimeFormat(ranges, format.scan_period, where);
      format.time_field = field;
      return true;
    } catch (const InputError& error) {
      if (first_error.empty()) first_error = error.what();
    }
  }
  if (!first_error.empty()) throw InputError(first_error);
  return false;
}

void RequireSpinning(const std::vector<RawCloud>& probe, const LidarFormat& format) {
  for (const RawCloud& raw : probe) {
    const DecodedCloud cloud = DecodeCloud(raw, format.topic, "");
    if (TimesFromAzimuth(cloud.positions, cloud.rings, format.scan_period)) continue;
    throw InputError(
        "topic " + format.topic + ": the points have no times (fields: " + format.fields +
        ") and do not look like a full revolution of a spinning LiDAR; set the driver to write "
        "a time for each point (field time, t, timestamp, offset_time or time_stamp) and record again");
  }
}

// Seconds after the scan's start for each point; nothing when they fit the format no more.
std::optional<std::vector<float>> PointTimes(const DecodedCloud& cloud, const LidarFormat& format,
                                             TimeNs& start) {
  if (format.time_field.empty()) {
    start = cloud.stamp;
    return TimesFromAzimuth(cloud.positions, cloud.rings, format.scan_period);
  }
  const auto range = TimeRangeOf(cloud);
  if (!range || !FitsFormat(format.time, *range, format.scan_period)) return std::nullopt;
  const ScanTimeBase base = TimeBaseOf(format.time, *range);
  start = base.start;
  std::vector<float> times(cloud.times.size());
  for (std::size_t i = 0; i < times.size(); ++i) {
    times[i] = static_cast<float>((cloud.times[i] - base.first_value) * format.time.seconds_per_count);
  }
  return times;
}

}  // namespace

LidarFormat FindLidarFormat(const std::vector<RawCloud>& probe, const std::string& topic) {
  if (probe.size() < 2) {
    throw InputError("topic " + topic + ": " + std::to_string(probe.size()) +
                     " message(s) in the chosen time; expected many scans of a drive");
  }
  LidarFormat format;
  format.topic = topic;
  format.fields = DescribeFields(probe.front());
  std::vector<TimeNs> stamps;
  for (const RawCloud& raw : probe) {
    const DecodedCloud cloud = DecodeCloud(raw, topic, "");
    if (format.frame_id.empty()) format.frame_id = cloud.frame_id;
    format.livox_other_clock |= cloud.time_base_in_other_clock;
    stamps.push_back(cloud.stamp);
  }
  format.scan_period = MedianPeriod(stamps);
  if (format.scan_period <= 0.0) {
    throw InputError("topic " + topic + ": all header stamps are the same (" +
                     std::to_string(1e-9 * static_cast<double>(stamps.front())) +
                     " s); expected the time of measurement of each scan");
  }
  if (!FindTimeField(probe, format)) RequireSpinning(probe, format);
  return format;
}

std::string DescribeTimes(const LidarFormat& format) {
  if (format.time_field.empty())
    return "no point times: taken from the azimuth, the stamp at the start of the scan";
  return "times from field '" + format.time_field + "', " + Describe(format.time);
}

ReadScan ReadOneScan(const RawCloud& raw, const LidarFormat& format) {
  ReadScan result;
  result.record_time = raw.record_time;
  try {
    const DecodedCloud cloud = DecodeCloud(raw, format.topic, format.time_field);
    result.stamp = cloud.stamp;
    const bool any = std::any_of(cloud.positions.begin(), cloud.positions.end(), HasReturn);
    if (!any) {
      result.problem = ReadScan::Problem::kNoReturns;
      return result;
    }
    const auto times = PointTimes(cloud, format, result.start);
    if (!times) {
      result.problem = ReadScan::Problem::kBadTimes;
      return result;
    }
    result.scan.points.resize(cloud.positions.size());
    for (std::size_t i = 0; i < cloud.positions.size(); ++i) {
      LidarPoint& point = result.scan.points[i];
      point.position = cloud.positions[i];
      point.time = (*times)[i];
      if (!cloud.intensities.empty()) point.intensity = cloud.intensities[i];
      if (!cloud.rings.empty()) point.ring = cloud.rings[i];
    }
    result.counts = FilterScan(result.scan);
  } catch (const InputError& error) {
    result.problem = ReadScan::Problem::kMalformed;
    result.error = error.what();
  }
  return result;
}

}  // namespace mlic
