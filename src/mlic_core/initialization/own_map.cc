#include "mlic_core/initialization/own_map.h"

#include <algorithm>
#include <limits>

#include "mlic_core/association/plane_association.h"
#include "mlic_core/common/order_statistics.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/initialization/pose_fit.h"

namespace mlic {
namespace {

constexpr std::size_t kFewestScans = 5;  // from: guard
constexpr std::size_t kPoints = 2000;    // of each scan, in its map; from: guard, time
constexpr double kLongest = 60.0;        // s, more adds little and takes memory; from: guard, memory
// s, of a parked vehicle. The same beams on the same places err in the same way again and again, and no
// residual shows it: in the rounds each counts once. from: derivation, ten scans or so
constexpr double kLongestParkedMaps = 5.0, kLongestParkedRounds = 1.0;
constexpr double kParked = 0.05;  // m and rad; from: guard, drift of the odometry

bool IsParked(const std::vector<TimedPose>& poses) {
  return std::all_of(poses.begin(), poses.end(), [](const TimedPose& pose) {
    return pose.pose.translation.norm() < kParked &&
           AngleBetween(pose.pose.rotation, Eigen::Quaterniond::Identity()) < kParked;
  });
}

}  // namespace

UsedStretches ChooseStretches(const DriveOdometry& odometry) {
  TimeInterval stretch{-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  bool parked = true;
  for (const std::vector<TimedPose>& poses : odometry.lidars) {
    if (poses.size() < kFewestScans) continue;
    stretch.start = std::max(stretch.start, poses.front().time);
    stretch.end = std::min(stretch.end, poses.back().time);
    parked = parked && IsParked(poses);
  }
  if (!(stretch.end > stretch.start)) return {};
  const auto at_most = [&](double seconds) {
    return TimeInterval{stretch.start, std::min(stretch.end, stretch.start + seconds)};
  };
  if (!parked) return {at_most(kLongest), at_most(kLongest), false};
  return {at_most(kLongestParkedMaps), at_most(kLongestParkedRounds), true};
}

std::vector<LidarRecording> ScansWithin(const TimeInterval& stretch, const Drive& drive) {
  std::vector<LidarRecording> within;
  for (const LidarRecording& recording : drive.lidars) {
    LidarRecording& part = within.emplace_back();
    part.scan_period = recording.scan_period;
    part.point_times_from_azimuth = recording.point_times_from_azimuth;
    for (const LidarScan& scan : recording.scans) {
      if (stretch.Contains(scan.time)) part.scans.push_back(scan);
    }
  }
  return within;
}

OwnMap MakeOwnMap(const Drive& drive, std::size_t lidar, const std::vector<TimedPose>& poses, double moment) {
  OwnMap map;
  const std::vector<LidarScan>& scans = drive.lidars[lidar].scans;
  if (scans.empty()) return map;
  for (const TimedPose& pose : poses) {
    if (pose.time >= scans.front().time && pose.time <= scans.back().time + drive.lidars[lidar].scan_period) {
      map.poses.push_back(pose);
    }
  }
  if (map.poses.size() < kFewestScans) return {};
  const RigidTransform T_lidar_odom = PoseAt(map.poses, moment).Inverse();
  for (TimedPose& pose : map.poses) pose.pose = T_lidar_odom * pose.pose;
  CalibrationState state;
  state.lidars.resize(drive.lidars.size());
  const double period = MedianPeriod(map.poses);
  state.drives.emplace_back().trajectory = SplineThrough(map.poses, KnotSpacing{period, period});
  AssociationOptions options;
  options.root_voxel = RootVoxelSize(drive);
  options.points_per_scan = kPoints;
  options.lidars.assign(drive.lidars.size(), false);
  options.lidars[lidar] = true;
  map.planes = AssociatePlanes(drive, state, 0, std::vector<PlaneNoise>(drive.lidars.size()), options).planes;
  return map;
}

std::vector<MapPlane> MovedBy(const RigidTransform& T, std::vector<MapPlane> planes) {
  for (MapPlane& plane : planes) {
    plane.center = T * plane.center;
    plane.plane.normal = T.rotation * plane.plane.normal;
    plane.plane.offset = plane.plane.normal.dot(plane.center);
  }
  return planes;
}

bool MovesAlike(const std::vector<TimedPose>& root, const std::vector<TimedPose>& lidar, double offset,
                const RigidTransform& T_root_lidar) {
  constexpr double kInterval = 1.0;  // s; from: structural
  // m and of the way. from: guard, odometry drifts ten times less, another turn of the LiDAR shows ten times
  // more
  constexpr double kMostTurn = 1.0 * M_PI / 180.0, kMostShift = 0.15, kMostShare = 0.03;
  std::vector<double> turns, shifts;
  for (const TimedPose& from : lidar) {
    const double t = from.time + offset;
    if (t < root.front().time || t + kInterval > root.back().time ||
        from.time + kInterval > lidar.back().time) {
      continue;
    }
    const RigidTransform of_lidar = from.pose.Inverse() * PoseAt(lidar, from.time + kInterval);
    const RigidTransform of_root = PoseAt(root, t).Inverse() * PoseAt(root, t + kInterval);
    const RigidTransform a = of_root * T_root_lidar, b = T_root_lidar * of_lidar;
    turns.push_back(AngleBetween(a.rotation, b.rotation));
    shifts.push_back((a.translation - b.translation).norm() - kMostShare * of_root.translation.norm());
  }
  return turns.empty() || (Median(turns) < kMostTurn && Median(shifts) < kMostShift);
}

}  // namespace mlic
