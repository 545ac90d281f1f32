#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "mlic_core/geometry/plane.h"

namespace mlic {

// Noise of a LiDAR's points along a surface's normal: sigma^2 = (range * cos(incidence))^2 + floor^2. Metres.
// The floor holds what does not scale with the incidence: beam direction, unevenness, and the trajectory's
// error.
struct PlaneNoise {
  double range = 0.02;
  double floor = 0.05;
  // By how much what a group's points share makes the variance of their sum grow beyond that of independent
  // ones, at 1, 2, 4, ... points (group_errors.h).
  std::array<double, 12> shared = {};

  double Sigma(double cos_incidence) const {
    return std::sqrt(range * range * cos_incidence * cos_incidence + floor * floor);
  }
};

// A point in the map frame with where it was seen from.
struct MapSample {
  Eigen::Vector3f position;
  Eigen::Vector3f view;  // unit vector from the point to the sensor
  double time = 0.0;     // s, one clock for all LiDARs
  std::int32_t lidar = 0;
  std::int32_t scan = 0;
  std::int32_t index = 0;  // of the point in its scan
};

// A planar patch of the map, found in one voxel and seen from one side within one stretch of time. The normal
// points to the sensors.
struct MapPlane {
  Plane plane;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis_u =
      Eigen::Vector3d::Zero();  // in-plane principal directions, one standard deviation long
  Eigen::Vector3d axis_v = Eigen::Vector3d::Zero();
  // By how much the points scatter more than their noise says, at least 1: uneven ground, curved bodywork.
  double inflation = 1.0;
  double start = 0.0;                  // s, the time of its first point
  std::uint64_t voxel = 0;             // and stretch of time that it was found in; the same from map to map
  std::vector<std::uint32_t> samples;  // indices of its points, in order of (lidar, scan, index)
};

struct PlaneMapOptions {
  double root_voxel = 2.0;  // m; halved down to an eighth; from: structural, the caller sets it
  // s over which one plane lasts, from the first point of its root voxel on.
  double longest = std::numeric_limits<double>::infinity();
  // from: guard, time and memory.
  std::size_t largest_count = 2000;  // planes kept, those with most points first
  // Of the planes of the map drawn before, in ascending order; empty: there is none. Voxels at the limit
  // between plane and none stay what they were (hysteresis), or maps would differ from one to the next.
  std::vector<std::uint64_t> last_voxels;
};

// The adaptive voxel map: a root voxel is a plane if its points fit one within their noise, else it splits in
// eight (Liu and Zhang, BALM, RA-L 2021). Points at grazing incidence (beyond 75 deg), off the plane by more
// than 3 sigma, or on the other side of a thin wall do not belong to a plane; the other side makes a plane of
// its own. Each stretch of time is fitted by itself: where the trajectory has drifted between two visits, one
// plane through both would cut off the far tail of each visit's points and so pull it to the other. Planes
// come in order of their start. noise: for each LiDAR. The result does not depend on the number of threads.
std::vector<MapPlane> BuildPlaneMap(const std::vector<MapSample>& samples,
                                    const std::vector<PlaneNoise>& noise, const PlaneMapOptions& options);

}  // namespace mlic
