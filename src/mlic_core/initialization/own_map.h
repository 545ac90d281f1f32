#pragma once

#include <cstddef>
#include <vector>

#include "mlic_core/common/time_interval.h"
#include "mlic_core/geometry/timed_pose.h"
#include "mlic_core/initialization/lidar_imu.h"
#include "mlic_core/lidar/plane_map.h"
#include "mlic_core/sensors/measurements.h"

namespace mlic {

// What of a drive is used, no more than pays. Of no length where the LiDARs do not record at one time.
struct UsedStretches {
  TimeInterval maps;    // to lay the LiDARs' maps into one another
  TimeInterval rounds;  // for the joint rounds, within the former
  bool parked = false;  // nothing moves: no scan tells when it was taken
};
UsedStretches ChooseStretches(const DriveOdometry& odometry);

// The LiDARs' scans within the stretch.
std::vector<LidarRecording> ScansWithin(const TimeInterval& stretch, const Drive& drive);

// What one LiDAR's odometry shows by itself: where it was, and the planes that it saw, in its own frame at
// one moment. Empty where it has too few scans.
struct OwnMap {
  std::vector<TimedPose> poses;  // its own clock
  std::vector<MapPlane> planes;
};

// poses: of its odometry. moment: on its own clock.
OwnMap MakeOwnMap(const Drive& drive, std::size_t lidar, const std::vector<TimedPose>& poses, double moment);

// The planes as seen from another frame.
std::vector<MapPlane> MovedBy(const RigidTransform& T, std::vector<MapPlane> planes);

// Whether a LiDAR at T_root_lidar moves as the root does: in the median over motions of a second, to what
// odometry drifts. offset: of its clock to the root's, s. True where they have no such motion in common.
bool MovesAlike(const std::vector<TimedPose>& root, const std::vector<TimedPose>& lidar, double offset,
                const RigidTransform& T_root_lidar);

}  // namespace mlic
