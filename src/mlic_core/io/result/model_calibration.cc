#include "mlic_core/io/result/model_calibration.h"

#include <limits>

#include "mlic_core/common/error.h"

namespace mlic {
namespace {

PoseSigma ExactPose() {
  PoseSigma sigma;
  sigma.time_offset = std::numeric_limits<double>::quiet_NaN();
  return sigma;
}

// tf takes no leading slash, and URDF has none.
std::string LinkOf(const std::string& frame) {
  return frame.substr(frame.find_first_not_of('/') == 0 ? 0 : 1);
}

// False, with a line, where the model does not place it.
template <typename Config>
bool Take(const RobotModel& model, const std::string& imu, const Config& config, SensorResult::Type type,
          CalibrationResult* calibration, std::vector<std::string>* left_out) {
  const auto pose = config.frame_id.empty() ? std::nullopt : model.Pose(imu, LinkOf(config.frame_id));
  if (!pose) {
    left_out->push_back(config.name + " (the model has no fixed joints from " + imu + " to its frame '" +
                        config.frame_id + "')");
    return false;
  }
  SensorResult sensor;
  sensor.name = config.name;
  sensor.type = type;
  sensor.frame_id = config.frame_id;
  sensor.topic = config.topic;
  sensor.calibration.T_imu_sensor = *pose;
  sensor.sigma = ExactPose();
  calibration->sensors.push_back(sensor);
  return true;
}

// The link of the IMU; InputError where the model has none.
std::string ImuLink(const RobotModel& model, const ImuConfig& config) {
  const std::string imu = config.frame_id.empty() ? "" : LinkOf(config.frame_id);
  if (!model.Has(imu)) {
    throw InputError("the robot's model has no link '" + imu + "', the frame of the IMU's messages on " +
                     config.topic + "; add it with its joint");
  }
  return imu;
}

}  // namespace

void TakeGuesses(const RobotModel& model, Rig* rig, std::vector<std::string>* notes) {
  const std::string imu = ImuLink(model, rig->imu);
  const auto take = [&](auto& config) {
    const auto pose = config.frame_id.empty() ? std::nullopt : model.Pose(imu, LinkOf(config.frame_id));
    if (!pose) {
      notes->push_back(config.name + ": the model has no fixed joints from " + imu + " to its frame '" +
                       config.frame_id + "': no guess from it");
      return;
    }
    config.guess = ExtrinsicGuess();
    config.guess->T_imu_sensor = *pose;
  };
  for (LidarConfig& lidar : rig->lidars) take(lidar);
  for (CameraConfig& camera : rig->cameras) take(camera);
}

CalibrationResult CalibrationOfModel(const RobotModel& model, const Rig& rig,
                                     std::vector<std::string>* left_out) {
  const std::string imu = ImuLink(model, rig.imu);
  CalibrationResult calibration;
  calibration.verdict = Verdict::kTrusted;
  calibration.imu_frame_id = imu;
  for (const LidarConfig& lidar : rig.lidars) {
    Take(model, imu, lidar, SensorResult::Type::kLidar, &calibration, left_out);
  }
  for (const CameraConfig& camera : rig.cameras) {
    if (!camera.intrinsics) {
      left_out->push_back(camera.name + " (no intrinsics: neither CameraInfo nor the rig file gives them)");
      continue;
    }
    if (!Take(model, imu, camera, SensorResult::Type::kCamera, &calibration, left_out)) continue;
    calibration.sensors.back().intrinsics = CameraIntrinsics{camera.model, 0, 0, *camera.intrinsics};
  }
  for (std::size_t a = 0; a < calibration.sensors.size(); ++a) {
    for (std::size_t b = a + 1; b < calibration.sensors.size(); ++b) {
      const SensorResult &first = calibration.sensors[a], &second = calibration.sensors[b];
      calibration.pairs.push_back({first.name, second.name,
                                   first.calibration.T_imu_sensor.Inverse() * second.calibration.T_imu_sensor,
                                   ExactPose()});
    }
  }
  return calibration;
}

}  // namespace mlic
