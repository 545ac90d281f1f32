#include "mlic_core/io/result/lidar_odometry_configs.h"

#include <string>

#include "mlic_core/io/result/number_list.h"
#include "mlic_core/io/result/radtan_fit.h"
#include "mlic_core/io/text_file.h"

namespace mlic {
namespace {

std::vector<const SensorResult*> SensorsOf(const CalibrationResult& result, SensorResult::Type type) {
  std::vector<const SensorResult*> sensors;
  for (const SensorResult& sensor : result.sensors) {
    if (sensor.type == type) sensors.push_back(&sensor);
  }
  return sensors;
}

std::string RotationOf(const RigidTransform& pose) { return RowByRow(pose.rotation.toRotationMatrix()); }

std::string Offset(const SensorResult& sensor) { return FixedNumber(sensor.calibration.time_offset, 9); }

// extrinsic_T and extrinsic_R of both FAST-LIO and FAST-LIVO2.
std::string LidarInImu(const SensorResult& lidar) {
  const RigidTransform& pose = lidar.calibration.T_imu_sensor;
  return "  # p_imu = extrinsic_R * p_lidar + extrinsic_T, metres\n  extrinsic_T: " +
         NumberList(pose.translation) + "\n  extrinsic_R: " + RotationOf(pose) + "\n";
}

// Empty where FAST-LIVO2 has no model for it.
std::string FastLivo2Camera(const SensorResult& camera) {
  const CameraIntrinsics& intrinsics = *camera.intrinsics;
  const bool fisheye = intrinsics.model == CameraModel::kEquidistant;
  const std::optional<RadtanCamera> radtan = AsRadtan(intrinsics);
  if (!fisheye && !radtan) return "";
  const std::vector<double>& p = fisheye ? intrinsics.parameters : radtan->pinhole;
  std::string text = radtan && !radtan->remark.empty() ? "# " + radtan->remark + "\n" : "";
  text += std::string("cam_model: ") + (fisheye ? "EquidistantCamera" : "Pinhole") +
          "\ncam_width: " + std::to_string(intrinsics.width) +
          "\ncam_height: " + std::to_string(intrinsics.height) + "\n";
  const char* const names[] = {"cam_fx", "cam_fy", "cam_cx", "cam_cy"};
  for (std::size_t i = 0; i < 4; ++i) text += std::string(names[i]) + ": " + FixedNumber(p[i], 12) + "\n";
  for (std::size_t i = 0; i < 4; ++i) {
    text += (fisheye ? "k" + std::to_string(i + 1) : "cam_d" + std::to_string(i)) + ": " +
            FixedNumber(fisheye ? p[4 + i] : radtan->distortion[i], 12) + "\n";
  }
  return text;
}

std::string FastLivo2Text(const SensorResult& lidar, const SensorResult& camera) {
  const RigidTransform T_camera_lidar =
      camera.calibration.T_imu_sensor.Inverse() * lidar.calibration.T_imu_sensor;
  return "extrin_calib:\n" + LidarInImu(lidar) +
         "  # p_camera = Rcl * p_lidar + Pcl, metres\n  Rcl: " + RotationOf(T_camera_lidar) +
         "\n  Pcl: " + NumberList(T_camera_lidar.translation) +
         "\ntime_offset:\n  # t_imu - imu_time_offset = t_lidar + lidar_time_offset = t_image + "
         "img_time_offset, seconds\n" +
         "  imu_time_offset: 0.0\n  lidar_time_offset: " + Offset(lidar) +
         "\n  img_time_offset: " + Offset(camera) + "\n  exposure_time_init: 0.0\n";
}

}  // namespace

std::vector<ExportedFile> FastLioFiles(const CalibrationResult& result) {
  std::vector<ExportedFile> files;
  for (const SensorResult* lidar : SensorsOf(result, SensorResult::Type::kLidar)) {
    files.push_back(
        {lidar->name + ".yaml",
         "common:\n  time_sync_en: false\n  # t_imu = t_lidar + time_offset_lidar_to_imu, seconds\n"
         "  time_offset_lidar_to_imu: " +
             Offset(*lidar) + "\nmapping:\n  extrinsic_est_en: false\n" + LidarInImu(*lidar)});
  }
  return files;
}

std::vector<ExportedFile> LioSamFiles(const CalibrationResult& result) {
  std::vector<ExportedFile> files;
  for (const SensorResult* lidar : SensorsOf(result, SensorResult::Type::kLidar)) {
    const RigidTransform T_lidar_imu = lidar->calibration.T_imu_sensor.Inverse();
    files.push_back(
        {lidar->name + ".yaml",
         "lio_sam:\n  imuGravity: " + FixedNumber(result.gravity.norm(), 6) +
             "\n  # p_lidar = extrinsicRot * p_imu + extrinsicTrans, metres.\n"
             "  # extrinsicRPY is for an orientation of the same axes as the rates.\n  extrinsicTrans: " +
             NumberList(T_lidar_imu.translation) + "\n  extrinsicRot: " + RotationOf(T_lidar_imu) +
             "\n  extrinsicRPY: " + RotationOf(T_lidar_imu) +
             "\n  # No place for the time offset: t_imu = t_lidar + (" + Offset(*lidar) + " s).\n"});
  }
  return files;
}

std::vector<ExportedFile> FastLivo2Files(const CalibrationResult& result) {
  std::vector<ExportedFile> files;
  for (const SensorResult* camera : SensorsOf(result, SensorResult::Type::kCamera)) {
    if (!camera->intrinsics) continue;
    const std::string text = FastLivo2Camera(*camera);
    if (text.empty()) continue;
    const std::vector<const SensorResult*> lidars = SensorsOf(result, SensorResult::Type::kLidar);
    for (const SensorResult* lidar : lidars) {
      files.push_back({lidar->name + "_" + camera->name + ".yaml", FastLivo2Text(*lidar, *camera)});
    }
    if (!lidars.empty()) files.push_back({"camera_" + camera->name + ".yaml", text});
  }
  return files;
}

}  // namespace mlic
