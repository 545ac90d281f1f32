#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "mlic_core/common/time.h"
#include "mlic_core/lidar/point_time.h"

namespace mlic {

// Raw values of a field that may hold the times of the points, one for each point.
struct PointTimeField {
  std::string name;
  std::vector<double> values;
};

// The points of one LiDAR message in its order, whatever the driver's layout. All vectors have the same
// length, or are empty when the message has no such field.
struct DecodedCloud {
  TimeNs stamp = 0;        // header stamp; for the Livox message its timebase, if that runs in the same clock
  TimeNs record_time = 0;  // when the message was recorded
  std::string frame_id;
  std::string fields;                      // names and types, for reports
  std::vector<Eigen::Vector3f> positions;  // m; not finite or zero where there was no return
  std::vector<float> intensities;
  std::vector<std::uint16_t> rings;
  std::vector<PointTimeField> times;  // in the order in which they are to be tried
  // Livox: timebase is far from the header stamp, which is used instead.
  bool time_base_in_other_clock = false;
};

// Whether a point is a return: finite and off the origin.
bool HasReturn(const Eigen::Vector3f& point);

// Over the points with a return and a finite time; nothing where there is none.
std::optional<PointTimeRange> TimeRangeOf(const DecodedCloud& cloud, const PointTimeField& times);

}  // namespace mlic
