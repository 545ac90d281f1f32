#pragma once

#include <string>
#include <vector>

#include "mlic_core/ingest/decoded_cloud.h"
#include "mlic_core/lidar/point_time.h"

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

// probe: some messages of the topic with every field that may hold times; at least two. Throws InputError
// where the points have no usable times: see point_time.h; a LiDAR without times must spin.
LidarFormat FindLidarFormat(const std::vector<DecodedCloud>& probe, const std::string& topic);

// For people: the field, its unit and reference.
std::string DescribeTimes(const LidarFormat& format);

}  // namespace mlic
