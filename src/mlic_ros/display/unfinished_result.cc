#include "mlic_ros/display/unfinished_result.h"

#include "mlic_core/io/result/point_cloud_file.h"
#include "mlic_core/io/result/result_file.h"
#include "mlic_core/io/result/trajectory_file.h"

namespace mlic {

CalibrationResult UnfinishedResult(const CalibrationSnapshot& snapshot, const std::string& imu_frame) {
  CalibrationResult result;
  result.verdict = Verdict::kRefused;
  result.reasons = {"unfinished: the state after round " + std::to_string(snapshot.iteration + 1) + " of " +
                    snapshot.stage + ", exported while the calibration ran; not for use"};
  result.imu_frame_id = imu_frame;
  const std::size_t lidars = snapshot.sensors.size() - snapshot.intrinsics.size();
  for (std::size_t i = 0; i < snapshot.sensors.size(); ++i) {
    SensorResult sensor;
    sensor.name = snapshot.sensor_names[i];
    sensor.frame_id = snapshot.sensor_frames[i];
    sensor.calibration = snapshot.sensors[i];
    if (i < snapshot.sigmas.size()) sensor.sigma = snapshot.sigmas[i];
    if (i >= lidars) {
      sensor.type = SensorResult::Type::kCamera;
      sensor.intrinsics = snapshot.intrinsics[i - lidars];
    }
    result.sensors.push_back(sensor);
  }
  result.trajectories = {snapshot.trajectory};
  result.map = snapshot.points;
  return result;
}

void WriteUnfinished(const std::filesystem::path& directory, const CalibrationResult& result) {
  std::filesystem::create_directories(directory);
  if (!result.trajectories[0].empty()) {
    WriteTrajectoryFile(directory / "trajectory.tum", result.trajectories[0]);
  }
  if (!result.map.empty()) WritePointCloudFile(directory / "map.pcd", result.map);
  WriteCalibrationFile(directory / "calibration.yaml", result);
}

}  // namespace mlic
