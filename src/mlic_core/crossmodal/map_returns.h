#pragma once

#include <Eigen/Core>
#include <cstddef>
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

// Where a point of a LiDAR (its index) is in the LiDAR's frame, when that is not where it was measured.
using PointCorrection = std::function<Eigen::Vector3f(std::size_t lidar, const LidarPoint& point)>;

// The returns of a drive's scans whose stamps lie in a window (IMU clock; all without one), at the given
// calibration (lidars[i] belongs to drive.lidars[i]), in order of LiDAR and time; times outside the
// trajectory's span are left out, and so are LiDARs that are marked so (none: all take part). At most
// largest_count, picked evenly.
std::vector<MapReturn> CollectReturns(const Drive& drive, const SplitSpline& trajectory,
                                      const std::vector<SensorCalibration>& lidars, std::size_t largest_count,
                                      const std::optional<TimeInterval>& window = std::nullopt,
                                      const PointCorrection& correction = nullptr,
                                      const std::vector<bool>& left_out = {});

}  // namespace mlic
