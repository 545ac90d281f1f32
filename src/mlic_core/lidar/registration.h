#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "mlic_core/geometry/rigid_transform.h"
#include "mlic_core/lidar/deskew.h"
#include "mlic_core/lidar/voxel_hash_map.h"

namespace mlic {

// A point as it was measured, and when: seconds after the middle of its scan.
struct TimedPoint {
  Eigen::Vector3d position;
  double time;
};

// T_odom_lidar at the middle of a scan, and the velocity there.
struct MotionState {
  RigidTransform pose;
  Twist twist;
};

// Mean velocity between the middles of two scans: angular in the LiDAR's frame, linear in the odometry's.
struct MeanVelocity {
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();
};

// What is known of the motion before the scan is looked at. Sigmas of one axis each.
struct MotionPrior {
  RigidTransform previous;  // pose of the scan before
  MotionState predicted;    // start of the search
  double interval = 0.1;    // s, from the previous scan's middle to this one's
  // The velocity at this scan's middle is a + extrapolation * (a - velocity_before), with the mean velocity a
  // since the scan before; it is tied to the pose, or pose and velocity would swing against each other from
  // scan to scan.
  MeanVelocity velocity_before;
  double extrapolation = 0.5;
  // From the accelerometer: the linear velocity at this scan's middle less the mean since the scan before, in
  // the odometry's frame, m/s. Replaces the extrapolation.
  std::optional<Eigen::Vector3d> velocity_gain;
  double sigma_angular_velocity = 1.0;  // rad/s
  double sigma_linear_velocity = 1.0;   // m/s
  double sigma_rotation = 0.1;          // rad, of the predicted pose
  double sigma_translation = 0.1;       // m
  // From the gyroscope, with linear velocity zero; nullptr without one. Then the angular velocity is not
  // estimated.
  const ScanMotion* rotation = nullptr;
};

// The motion during the scan whose middle is at `state`. The angular acceleration is that between the
// last two mean velocities.
ScanMotion MotionDuring(const MotionState& state, const MotionPrior& prior, double half_span);

MeanVelocity VelocityBetween(const RigidTransform& from, const RigidTransform& to, double interval);

struct RegistrationResult {
  MotionState state;
  double residual_rms = 0.0;  // of the matched points on planes, m
};

// Registers the points of one scan to the map: Gauss-Newton over pose and velocity of the scan (12
// parameters) with the prior. The points are de-skewed by the velocity sought. Residuals are distances from
// planes, or from the middles of voxels that are not flat, with the Geman-McClure kernel; its width shrinks
// from `search_width` to three times `noise`, the points' usual distance from their planes (m).
//
// half_span: the largest time of a point. Returns the prediction when nothing matches.
RegistrationResult RegisterScan(const std::vector<TimedPoint>& points, double half_span,
                                const VoxelHashMap& map, const MotionPrior& prior, double search_width,
                                double noise);

}  // namespace mlic
