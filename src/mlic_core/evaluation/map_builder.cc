#include "mlic_core/evaluation/map_builder.h"

#include <algorithm>

#include "mlic_core/evaluation/pose_interpolation.h"

namespace mlic {
std::vector<MapPoint> BuildMap(const Drive& drive, const std::vector<std::string>& names,
                               const std::vector<StampedPose>& trajectory,
                               const CalibrationResult& calibration, std::size_t stride) {
  std::vector<MapPoint> map;
  if (trajectory.empty()) return map;
  const double middle = SecondsSince(drive.epoch, MiddleOf(trajectory));
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
        const double time = pose_and_clock.OnImuClock(scan.time + static_cast<double>(point.time), middle);
        if (!InterpolatePose(trajectory, TimeFrom(drive.epoch, time), &hint, &T_map_imu)) continue;
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
