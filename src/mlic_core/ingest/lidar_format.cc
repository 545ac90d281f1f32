#include "mlic_core/ingest/lidar_format.h"

#include <algorithm>

#include "mlic_core/common/error.h"
#include "mlic_core/lidar/azimuth_time.h"

namespace mlic {
namespace {

std::vector<PointTimeRange> TimeRangesOf(const std::vector<DecodedCloud>& probe, const std::string& field) {
  std::vector<PointTimeRange> ranges;
  for (const DecodedCloud& cloud : probe) {
    for (const PointTimeField& times : cloud.times) {
      if (times.name != field) continue;
      const auto range = TimeRangeOf(cloud, times);
      if (range) ranges.push_back(*range);
    }
  }
  return ranges;
}

// A field that every driver setting without times leaves at one value.
bool IsConstant(const std::vector<PointTimeRange>& ranges) {
  return std::all_of(ranges.begin(), ranges.end(), [](const auto& r) { return r.minimum == r.maximum; });
}

// Sets time_field and time from the first field that fits; false when the messages have no times at all.
bool FindTimeField(const std::vector<DecodedCloud>& probe, LidarFormat& format) {
  std::string first_error;
  for (const PointTimeField& times : probe.front().times) {
    const std::vector<PointTimeRange> ranges = TimeRangesOf(probe, times.name);
    if (ranges.empty() || IsConstant(ranges)) continue;
    try {
      const std::string where = "topic " + format.topic + ", point time field '" + times.name + "'";
      format.time = FindPointTimeFormat(ranges, format.scan_period, where);
      format.time_field = times.name;
      return true;
    } catch (const InputError& error) {
      if (first_error.empty()) first_error = error.what();
    }
  }
  if (!first_error.empty()) throw InputError(first_error);
  return false;
}

void RequireSpinning(const std::vector<DecodedCloud>& probe, const LidarFormat& format) {
  for (const DecodedCloud& cloud : probe) {
    if (TimesFromAzimuth(cloud.positions, cloud.rings, format.scan_period)) continue;
    throw InputError(
        "topic " + format.topic + ": the points have no times (fields: " + format.fields +
        ") and do not look like a full revolution of a spinning LiDAR; set the driver to write "
        "a time for each point (field time, t, timestamp, offset_time or time_stamp) and record again");
  }
}

}  // namespace

LidarFormat FindLidarFormat(const std::vector<DecodedCloud>& probe, const std::string& topic) {
  if (probe.size() < 2) {
    throw InputError("topic " + topic + ": " + std::to_string(probe.size()) +
                     " usable message(s) in the chosen time; expected many scans of a drive");
  }
  LidarFormat format;
  format.topic = topic;
  format.fields = probe.front().fields;
  std::vector<TimeNs> stamps;
  for (const DecodedCloud& cloud : probe) {
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

}  // namespace mlic
