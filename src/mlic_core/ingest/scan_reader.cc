#include "mlic_core/ingest/scan_reader.h"

#include <algorithm>
#include <optional>
#include <vector>

#include "mlic_core/lidar/azimuth_time.h"

namespace mlic {
namespace {

const PointTimeField* FindTimes(const DecodedCloud& cloud, const std::string& name) {
  for (const PointTimeField& times : cloud.times) {
    if (times.name == name) return &times;
  }
  return nullptr;
}

// Seconds after the scan's start for each point; nothing when they fit the format no more. times: null where
// they come from the azimuth.
std::optional<std::vector<float>> PointTimes(const DecodedCloud& cloud, const LidarFormat& format,
                                             const PointTimeField* times, TimeNs& start) {
  if (times == nullptr) {
    start = cloud.stamp;
    return TimesFromAzimuth(cloud.positions, cloud.rings, format.scan_period);
  }
  const auto range = TimeRangeOf(cloud, *times);
  if (!range || !FitsFormat(format.time, *range, format.scan_period)) return std::nullopt;
  const ScanTimeBase base = TimeBaseOf(format.time, *range);
  start = base.start;
  std::vector<float> seconds(times->values.size());
  for (std::size_t i = 0; i < seconds.size(); ++i) {
    seconds[i] = static_cast<float>((times->values[i] - base.first_value) * format.time.seconds_per_count);
  }
  return seconds;
}

}  // namespace

ReadScan MalformedScan(TimeNs record_time, const std::string& error) {
  ReadScan scan;
  scan.problem = ReadScan::Problem::kMalformed;
  scan.record_time = record_time;
  scan.error = error;
  return scan;
}

ReadScan MakeScan(const DecodedCloud& cloud, const LidarFormat& format) {
  ReadScan result;
  result.record_time = cloud.record_time;
  result.stamp = cloud.stamp;
  if (!std::any_of(cloud.positions.begin(), cloud.positions.end(), HasReturn)) {
    result.problem = ReadScan::Problem::kNoReturns;
    return result;
  }
  const PointTimeField* field = FindTimes(cloud, format.time_field);
  if (field == nullptr && !format.time_field.empty()) {
    return MalformedScan(cloud.record_time, "topic " + format.topic + ": field '" + format.time_field +
                                                "' is missing in some messages (" + cloud.fields +
                                                "); expected the same fields in all");
  }
  const auto times = PointTimes(cloud, format, field, result.start);
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
  return result;
}

}  // namespace mlic
