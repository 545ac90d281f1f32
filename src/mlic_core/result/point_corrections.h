#pragma once

#include <vector>

namespace mlic {

// What a LiDAR's points need added to where its driver has them: to the range in m,
//   range_offset + range_slope * elevation + range_walk * log10(intensity / reference_intensity) + its ring's
//   range, the logarithm at least -2 and at most 2,
// and to the elevation (rad, above the plane across the LiDAR's z axis) its ring's elevation.
struct PointCorrections {
  struct Ring {
    int ring = 0;  // as the driver numbers them in its messages
    double range = 0.0;
    double elevation = 0.0;
  };
  double range_offset = 0.0;
  double range_slope = 0.0;          // m/rad
  double range_walk = 0.0;           // m, by which echoes that are ten times weaker seem longer
  double reference_intensity = 0.0;  // as the driver writes intensities; 0 where there is no walk
  std::vector<Ring> rings;           // that need any

  bool Any() const {
    return range_offset != 0.0 || range_slope != 0.0 || range_walk != 0.0 || !rings.empty();
  }
};

}  // namespace mlic
