#pragma once

#include <memory>
#include <vector>

#include "mlic_core/geometry/timed_pose.h"
#include "mlic_core/sensors/measurements.h"
#include "mlic_sim/trajectory.h"

namespace mlic::sim {

// The path of a rig that was recorded, and what its IMU read along it: sensors are simulated there under a
// real IMU.
struct RecordedMotion {
  std::vector<TimedPose> path;      // T_map_imu, z up, on the IMU's clock, ascending in time
  std::vector<ImuSample> readings;  // on the same clock, ascending; empty: the IMU is simulated too
};

// From `begin` (s after the path's first pose) on for `duration` s: times start there at zero, and the path
// lies about the origin, its longer side along x, its lowest pose 1 m high, where the middle of the hall has
// room. The path goes on for up to a second to either side. InputError where it or the readings are too
// short.
RecordedMotion PartOf(const RecordedMotion& whole, double begin, double duration);

// Through the poses, by uniform B-splines of degree 5 with knots every four of their periods. InputError for
// fewer than 20 poses, or where some lie further apart than that.
std::unique_ptr<Trajectory> MakeRecordedTrajectory(const std::vector<TimedPose>& path);

}  // namespace mlic::sim
