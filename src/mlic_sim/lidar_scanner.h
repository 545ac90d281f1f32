#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "mlic_core/common/random.h"
#include "mlic_sim/lidar_model.h"
#include "mlic_sim/trajectory.h"
#include "mlic_sim/world.h"

namespace mlic::sim {

// One beam's outcome. A beam that did not come back has returned = false and a zero position.
struct SimulatedPoint {
  Eigen::Vector3f position = Eigen::Vector3f::Zero();  // sensor frame, m
  float intensity = 0.0f;                              // 0 to 255
  double time = 0.0;                                   // seconds after the scan's start
  std::uint16_t ring = 0;
  bool returned = false;
};

// Casts the beams of one scan that starts at `start` (s, IMU clock), each from where the LiDAR is at the
// beam's own time. With `noise` (drawn from): of the range, mixed pixels at edges, drop-outs by received
// power and by chance, rain and lost packets. Without: every beam that hits something within the ranges
// returns, with nothing but the model's ring bias and range walk. The outcome depends on the arguments only.
std::vector<SimulatedPoint> CastScan(const World& world, const Trajectory& trajectory,
                                     const RigidTransform& T_imu_lidar, const LidarModel& model,
                                     const std::vector<Firing>& firings, double start,
                                     std::optional<Random> noise);

// What a LiDAR reports as intensity, 0 to 255: reflectance x cosine of incidence x range falloff.
double IntensityOf(double near_infrared, double cos_incidence, double range);

}  // namespace mlic::sim
