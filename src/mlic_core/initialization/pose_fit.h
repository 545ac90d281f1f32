#pragma once

#include <vector>

#include "mlic_core/geometry/timed_pose.h"
#include "mlic_core/imu/excitation.h"
#include "mlic_core/initialization/knot_spacing.h"
#include "mlic_core/problem/state.h"
#include "mlic_core/sensors/measurements.h"

namespace mlic {

// Between the poses before and after; the first or last one beyond them.
RigidTransform PoseAt(const std::vector<TimedPose>& poses, double time);

// First guess of a trajectory's control points: the poses at their times.
SplitSpline SplineThrough(const std::vector<TimedPose>& poses, const UniformKnots& rotation_knots,
                          const UniformKnots& position_knots);

// The same with knots that reach half a pose's period beyond the poses.
SplitSpline SplineThrough(const std::vector<TimedPose>& poses, const KnotSpacing& spacing);

// One drive's trajectory and biases drawn to poses of the IMU and its samples, from a start. sigmas: of the
// poses (rad, m). By the joint problem's solver and not as a small fit: hundreds of control points, banded in
// time.
DriveState FitToPoses(const Drive& drive, const ImuSigma& imu_sigma, const std::vector<TimedPose>& poses,
                      double sigma_rotation, double sigma_translation, DriveState start);

}  // namespace mlic
