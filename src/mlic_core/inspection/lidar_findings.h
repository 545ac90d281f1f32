#pragma once

#include <optional>
#include <string>
#include <vector>

#include "mlic_core/ingest/decoded_cloud.h"
#include "mlic_core/ingest/lidar_format.h"
#include "mlic_core/inspection/finding.h"
#include "mlic_core/sensors/measurements.h"

namespace mlic {

// What one scan looks like. Ranges in metres; thinned: its points as the calibration would use them, time 0.
struct ScanSample {
  TimeNs stamp = 0;
  std::size_t points = 0;
  std::size_t returns = 0;
  double median_range = 0.0;
  double far_range = 0.0;  // 95 % of the returns are nearer
  bool intensity_varies = false;
  bool bad_times = false;  // they do not fit the format found at the start
  LidarScan thinned;
  // How fast the azimuth of one ring advances, rad/s, and the duration of its sweep, s; of scans that look
  // like a revolution.
  std::optional<double> azimuth_rate;
  double sweep = 0.0;
};

ScanSample MeasureScan(const DecodedCloud& cloud, const LidarFormat& format);

// What was read of one LiDAR topic: all messages for faults, some of them as samples, in order of time.
struct LidarSurvey {
  std::string name;
  std::optional<LidarFormat> format;
  std::string format_error;  // where there is no format: one line
  std::size_t messages = 0;
  std::size_t malformed = 0;
  std::string first_fault;
  std::vector<ScanSample> samples;
};

// Times of the points, malformed and empty messages, returns, ranges, intensity (which the cameras need), own
// body.
Findings LidarFindings(const LidarSurvey& lidar, bool with_cameras);

// Whether the driver has taken the motion out of the scans already: of a spinning LiDAR's raw points the
// azimuth advances at the motor's rate, of de-skewed ones at that plus the turning of the vehicle, which the
// gyroscope tells. imu: on the clock of the stamps less `epoch`. Nothing where it cannot be told.
Findings DeskewFindings(const LidarSurvey& lidar, const std::vector<ImuSample>& imu, TimeNs epoch);

}  // namespace mlic
