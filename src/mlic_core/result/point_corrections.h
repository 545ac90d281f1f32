#pragma once

#include <vector>

namespace mlic {

// What a LiDAR's points need added to where its driver has them: to the range in m,
//   range_offset + range_slope * elevation + its ring's range,
// and to the elevation (rad, above the plane across the LiDAR's z axis) its ring's elevation.
struct PointCorrections {
  struct Ring {
    int ring = 0;  // as the driver numbers them in its messages
    double range = 0.0;
    double elevation = 0.0;
  };
  double range_offset = 0.0;
  double range_slope = 0.0;  // m/rad
  std::vector<Ring> rings;   // that need any

  bool Any() const { return range_offset != 0.0 || range_slope != 0.0 || !rings.empty(); }
};

}  // namespace mlic
