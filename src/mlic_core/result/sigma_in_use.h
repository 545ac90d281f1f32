#pragma once

#include <vector>

namespace mlic {

constexpr int kUseSectors = 12;  // from: definition, of 30 deg each

// How far a point comes to lie from where it is, one standard deviation along the direction in which that is
// largest, when it is carried from one sensor to another by the calibration (docs/outputs.md).
struct SigmaInUse {
  enum class Where { kImage, kSpace };
  Where where = Where::kSpace;
  double distance = 0.0;  // m, of the point
  double median = 0.0;    // over the image or all directions about the horizon: px, m in space
  double worst = 0.0;
  // In space the worst of each sector of the horizon, counterclockwise from the one that begins at the
  // vehicle's front (vehicle_axes.h).
  std::vector<double> sectors = {};
};

}  // namespace mlic
