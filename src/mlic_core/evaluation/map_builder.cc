#include <algorithm>

#include "mlic_core/evaluation/map_quality.h"

namespace mlic {
namespace {

// Pose at a time by the two neighbours; false outside the trajectory. `next` is a hint, moved along as times
// grow.
bool PoseAt(const std::vector<StampedPose>& trajectory, TimeNs time, std::size_t* next,
            RigidTransform* pose) {
  const auto after = [](TimeNs t, const StampedPose& p) { return t < p.time; };
  std::size_t upper = *next;
  if (upper == 0 || upper >= trajectory.size() || trajectory[upper - 1].time > time ||
      trajectory[upper].time <= time) {
    upper = static_cast<std::size_t>(std::upper_bound(trajectory.begin(), trajectory.end(), time, after) -
                                     trajectory.begin());
  }
  if (upper == 0 || upper == trajectory.size()) return false;
  *next = upper;
  const StampedPose &a = trajectory[upper - 1], &b = trajectory[upper];
  const double u = static_cast<double>(time - a.time) / static_cast<double>(b.time - a.time);
  pose->rotation = a.pose.rotation.slerp(u, b.pose.rotation);
  pose->translation = (1.0 - u) * a.pose.translation + u * b.pose.translation;
  return true;
}

}  // namespace

std::vector<MapPoint> BuildMap(const Drive& drive, const std::vector<std::string>& names,
                               const std::vector<StampedPose>& trajectory,
                               const CalibrationResult& calibration, std::size_t stride) {
  std::vector<MapPoint> map;
  for (std::size_t l = 0; l < drive.lidars.size() && l < names.size(); ++l) {
    const auto sensor = std::find_if(calibration.sensors.begin(), calibration.sensors.end(),
                                     [&](const SensorResult& s) { return s.name == names[l]; });
    if (sensor == calibration.sensors.end()) continue;
    const SensorCalibration& pose_and_clock = sensor->calibration;
    std::size_t counter = 0, hint = 0;
    for (const LidarScan& scan : drive.lidars[l].scans) {
      for (const LidarPoint& point : scan.points) {
        if (counter++ % std::max<std::size_t>(1, stride) != 0) continue;
        RigidTransform T_map_imu;
        const double time = scan.time + static_cast<double>(point.time) + pose_and_clock.time_offset;
        if (!PoseAt(trajectory, TimeFrom(drive.epoch, time), &hint, &T_map_imu)) continue;
        MapPoint mapped;
        const Eigen::Vector3d in_imu = pose_and_clock.T_imu_sensor * point.position.cast<double>().eval();
        mapped.position = (T_map_imu * in_imu).cast<float>();
        mapped.intensity = point.intensity;
        mapped.lidar = static_cast<int>(sensor - calibration.sensors.begin());
        map.push_back(mapped);
      }
    }
  }
  return map;
}

}  // namespace mlic
