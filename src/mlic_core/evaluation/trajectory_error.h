#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "mlic_core/result/result.h"

namespace mlic {

// Error of relative motions over parts of one length (of the way, m) or one angle turned (degrees).
struct RelativeTrajectoryError {
  double extent = 0.0;            // of each part: m, or degrees
  std::size_t parts = 0;          // overlapping
  double translation_rms = 0.0;   // m
  double rotation_rms_deg = 0.0;  // geodesic
};

struct TrajectoryError {
  std::size_t poses = 0;  // of the reference within the trajectory
  double length = 0.0;    // of the reference's path, m
  double turned_deg = 0.0;

  // What brought the two together: the reference's world into the map, and the constant pose of the
  // reference's body in the IMU frame.
  RigidTransform T_map_world;
  RigidTransform T_imu_body;

  double translation_rms = 0.0, translation_mean = 0.0, translation_largest = 0.0;  // m
  double rotation_rms_deg = 0.0, rotation_largest_deg = 0.0;
  std::vector<RelativeTrajectoryError> over_metres;   // 1, 2, 5, 10, ... m, as far as the path goes
  std::vector<RelativeTrajectoryError> over_degrees;  // 10, 30, 90, ... deg
};

// Errors of a trajectory T_map_imu against reference poses T_world_body, both in order of time and on one
// clock. Aligned without scale. The body may be mounted anywhere on the rig: its lever arm is estimated along
// the directions that the motion shows and zero along the others, its rotation is the mean of all poses.
// Absolute errors are those after alignment; relative ones compare motions of the body, so that only drift
// counts (Zhang and Scaramuzza, IROS 2018). Path and angle are those of the reference, its poses thinned out
// to steps of 0.08 s or more, or its noise would count as way. InputError when fewer than ten
// poses lie within the trajectory.
TrajectoryError CompareTrajectories(const std::vector<StampedPose>& trajectory,
                                    const std::vector<StampedPose>& reference);

// For people: metres and degrees, drift in percent and in degrees per metre.
std::string TableOf(const TrajectoryError& error);

// kind,extent,count,translation_rms_m,rotation_rms_deg: absolute, then per_metres and per_degrees.
std::string CsvOf(const TrajectoryError& error);

}  // namespace mlic
