#pragma once

#include <Eigen/Core>
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

// What is known of the motion before the scan is looked at. Sigmas of one axis each.
struct MotionPrior {
  MotionState previous;   // of the scan before
  MotionState predicted;  // start of the search
  double interval = 0.1;  // s, from the previous scan's middle to this one's
  // The twist: this scan's minus the predicted one.
  double sigma_angular_velocity = 1.0;  // rad/s
  double sigma_linear_velocity = 1.0;   // m/s
  // The pose: motion since the previous scan minus interval times the mean of the two velocities.
  double sigma_rotation = 0.1;     // rad
  double sigma_translation = 0.1;  // m
  // From the gyroscope, linear velocity zero; nullptr without one. Then the angular velocity is not
  // estimated, and sigma_rotation is that of the predicted pose.
  const ScanMotion* rotation = nullptr;
};

struct RegistrationResult {
  MotionState state;
  double residual_rms = 0.0;  // of the matched points on planes, m
  double inlier_share = 0.0;  // matched points of all
  int iterations = 0;
};

// Registers the points of one scan to the map: Gauss-Newton over pose and velocity of the scan (12
// parameters) with the prior. The points are de-skewed by the velocity sought. Residuals are distances from
// planes, or from the middles of voxels that are not flat, with the Geman-McClure kernel; its width shrinks
// from `search_width` to three times `noise`, the points' usual distance from their planes (m).
//
// half_span: the largest time of a point. Returns the prediction with inlier_share 0 when nothing matches.
RegistrationResult RegisterScan(const std::vector<TimedPoint>& points, double half_span,
                                const VoxelHashMap& map, const MotionPrior& prior, double search_width,
                                double noise);

}  // namespace mlic
