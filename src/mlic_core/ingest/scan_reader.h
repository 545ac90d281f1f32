#pragma once

#include <string>

#include "mlic_core/ingest/decoded_cloud.h"
#include "mlic_core/ingest/lidar_format.h"
#include "mlic_core/lidar/scan_filter.h"
#include "mlic_core/sensors/measurements.h"

namespace mlic {

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

// The cloud holds the format's time field, or is malformed.
ReadScan MakeScan(const DecodedCloud& cloud, const LidarFormat& format);

// Of a message that could not be decoded; error: one line.
ReadScan MalformedScan(TimeNs record_time, const std::string& error);

}  // namespace mlic
