#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "mlic_core/common/time_interval.h"
#include "mlic_core/sensors/measurements.h"
#include "mlic_core/sensors/rig.h"
#include "mlic_core/trajectory/split_spline.h"

namespace mlic {

// One LiDAR return in the map frame.
struct MapReturn {
  Eigen::Vector3f position;  // m
  Eigen::Vector3f beam;      // from the sensor to the point, m, map frame
  float intensity = 0.0f;    // as the driver writes it
  std::uint16_t ring = 0;
  std::uint16_t lidar = 0;
  double time = 0.0;  // LiDAR clock, s since the drive's epoch
};

// A point of a surface as it is drawn.
struct SurfacePoint {
  Eigen::Vector3f position;  // m, map frame; range noise is reduced where the surface is a plane
  float intensity = 0.0f;    // 0 to 1, range, incidence and sensor compensated
  Eigen::Vector3f normal;    // unit, on the side it was seen from; zero where there is no plane
  float spacing = 0.0f;      // m, to the neighbours on the surface
  float weight = 1.0f;       // of its intensity among its neighbours': sharp, well-lit looks count more
};

// Which beam a point comes from.
struct PointOrigin {
  double time = 0.0;  // LiDAR clock, s since the drive's epoch
  std::int32_t lidar = 0;
};

// Points that lie near each other: [begin, end) of the map's points, all within radius of the center. Their
// order is random, so that the first k of them are an even choice.
struct MapCell {
  Eigen::Vector3f center;
  float radius = 0.0f;  // m
  std::uint32_t begin = 0, end = 0;
};

// The joint map of all LiDARs of one drive, made to be looked at by cameras. Points and origins go together.
struct IntensityMap {
  std::vector<SurfacePoint> points;
  std::vector<PointOrigin> origins;
  std::vector<MapCell> cells;
};

struct IntensityMapOptions {
  bool remove_moving = true;  // what other beams saw through at other times is left out
};

// Where a point of a LiDAR (its index) is in the LiDAR's frame, when that is not where it was measured.
using PointCorrection = std::function<Eigen::Vector3f(std::size_t lidar, const LidarPoint& point)>;

// The returns of a drive's scans whose stamps lie in a window (IMU clock; all without one), at the given
// calibration (lidars[i] belongs to drive.lidars[i]), in order of LiDAR and time; times outside the
// trajectory's span are left out. At most largest_count, picked evenly.
std::vector<MapReturn> CollectReturns(const Drive& drive, const SplitSpline& trajectory,
                                      const std::vector<SensorCalibration>& lidars, std::size_t largest_count,
                                      const std::optional<TimeInterval>& window = std::nullopt,
                                      const PointCorrection& correction = nullptr);

// The map of any returns (a drive's, or one scan's). Intensities of all LiDARs are brought to one scale from
// what they saw in common. The result does not depend on the number of threads.
IntensityMap BuildIntensityMap(const std::vector<MapReturn>& returns,
                               const IntensityMapOptions& options = {});

}  // namespace mlic
