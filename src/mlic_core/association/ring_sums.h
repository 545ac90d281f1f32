#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "mlic_core/association/ring_errors.h"
#include "mlic_core/problem/joint_problem.h"
#include "mlic_core/problem/state.h"

namespace mlic {

// What one ring's points were.
struct RingPoints {
  double count = 0.0;
  double elevation = 0.0;  // sum, rad
};

// What a part of a LiDAR's points says of its rings, by their numbers, beyond the corrections that they have.
// Each plane is free for each LiDAR and part, so that only differences between rings on one plane count: what
// all of them share there (uneven ground, the LiDAR's place, the trajectory) is not taken for the rings'.
struct RingSum {
  RingEquations equations;
  std::vector<RingPoints> points;

  explicit RingSum(std::size_t rings = 0)
      : equations(RingEquations::Zero(static_cast<Eigen::Index>(rings))), points(rings) {}
  void Add(const RingSum& other);
};

// One LiDAR's points by the half of the drive and by the side of its view: early left, early right, late
// left, late right.
using QuartersOfRings = std::array<RingSum, 4>;

// Of each LiDAR; without rings for one whose points carry none, or a number of 256 or more, as no laser has.
// Points beyond three sigmas do not count.
std::vector<QuartersOfRings> SumRings(const std::vector<DriveTerms>& drives, const CalibrationState& state);

// By how much a point's residual (m, along the beam) grows when its ring's range and elevation do: m per m, m
// per rad, where the beam meets the plane (the measured range would bring its noise in). The point lies
// within the trajectory.
Eigen::Vector2d RingJacobian(const PlaneObservation& point, double residual, const MapPlane& plane,
                             const SensorCalibration& lidar, const SplitSpline& trajectory);

// Towards higher elevation, one unit long times the distance from the z axis' foot: d position / d elevation.
// LiDAR frame, m.
Eigen::Vector3d ElevationTangent(const Eigen::Vector3d& position);

// Above the plane across the LiDAR's z axis: rad.
double ElevationOf(const Eigen::Vector3f& position);

}  // namespace mlic
