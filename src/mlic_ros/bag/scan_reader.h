#pragma once

#include <optional>
#include <string>
#include <vector>

#include "mlic_core/lidar/point_time.h"
#include "mlic_core/lidar/scan_filter.h"
#include "mlic_core/sensors/measurements.h"
#include "mlic_ros/bag/cloud_decoder.h"

namespace mlic {

// How the messages of one LiDAR topic are to be read, found from some of them.
struct LidarFormat {
  std::string topic;
  std::string frame_id;
  std::string fields;
  std::string time_field;  // empty: times come from the azimuth
  PointTimeFormat time;
  double scan_period = 0.1;  // s
  bool livox_other_clock = false;
};

// Needs at least two messages. Throws InputError where the points have no usable times: see point_time.h; a
// LiDAR without times must spin.
LidarFormat FindLidarFormat(const std::vector<RawCloud>& probe, const std::string& topic);

// For people: the field, its unit and reference.
std::string DescribeTimes(const LidarFormat& format);

// One message as a thinned-out scan. scan.time is left at 0: `start` is the absolute time of the point with
// time 0.
struct ReadScan {
  enum class Problem { kNone, kNoReturns, kBadTimes, kMalformed };
  Problem problem = Problem::kNone;
  std::string error;  // of kMalformed
  TimeNs stamp = 0;
  TimeNs record_time = 0;
  TimeNs start = 0;
  LidarScan scan;
  ScanFilterCounts counts;
};

ReadScan ReadOneScan(const RawCloud& raw, const LidarFormat& format);

}  // namespace mlic
