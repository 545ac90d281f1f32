#include "mlic_core/io/write_results.h"

#include "mlic_core/io/pictures/projection_picture.h"
#include "mlic_core/io/pictures/track_picture.h"
#include "mlic_core/io/report/report.h"
#include "mlic_core/io/result/camera_info.h"
#include "mlic_core/io/result/correction_files.h"
#include "mlic_core/io/result/kalibr_camchain.h"
#include "mlic_core/io/result/point_cloud_file.h"
#include "mlic_core/io/result/result_file.h"
#include "mlic_core/io/result/sensor_tree.h"
#include "mlic_core/io/result/static_transforms.h"
#include "mlic_core/io/result/trajectory_file.h"
#include "mlic_core/io/result/urdf.h"
#include "mlic_core/io/text_file.h"

namespace mlic {
namespace {

namespace fs = std::filesystem;

std::string TrajectoryName(std::size_t drive) {
  return drive == 0 ? "trajectory.tum" : "trajectory_" + std::to_string(drive + 1) + ".tum";
}

// camera,stamp: the images whose features took part, stamps in nanoseconds as in the messages.
std::string KeyframesCsv(const std::vector<CameraKeyframes>& keyframes) {
  std::string csv = "camera,stamp_ns\n";
  for (const CameraKeyframes& camera : keyframes) {
    for (const TimeNs stamp : camera.stamps) csv += camera.camera + "," + std::to_string(stamp) + "\n";
  }
  return csv;
}

// What the joint adjustment started from, for comparisons.
void WriteInitialCalibration(const fs::path& path, const CalibrationResult& result) {
  CalibrationResult initial;
  initial.reasons = {"the state before the joint adjustment: for comparison, not for use"};
  initial.imu_frame_id = result.imu_frame_id;
  initial.sensors = result.initial_sensors;
  WriteCalibrationFile(path, initial);
}

}  // namespace

void WriteResults(const fs::path& directory, const CalibrationResult& result, const fs::path& place) {
  for (std::size_t drive = 0; drive < result.trajectories.size(); ++drive) {
    if (result.trajectories[drive].empty()) continue;
    WriteTrajectoryFile(directory / TrajectoryName(drive), result.trajectories[drive]);
  }
  if (!result.map.empty()) WritePointCloudFile(directory / "map.pcd", result.map);
  WriteTrackPictures(directory / "images", result.views);
  WriteProjectionPictures(directory / "images", result.projections);
  if (!result.keyframes.empty()) {
    WriteFileAtomically(directory / "images" / "keyframes.csv", KeyframesCsv(result.keyframes));
  }
  if (!result.initial_sensors.empty()) {
    WriteInitialCalibration(directory / "initial_calibration.yaml", result);
  }
  WriteReport(directory / "report.html", result, place);
  if (result.Usable()) {
    const SensorTree tree = TreeOf(result);
    WriteFileAtomically(directory / "static_transforms.launch",
                        StaticTransformsText(tree, TransformPublisher::kTf2));
    WriteFileAtomically(directory / "sensors.urdf.xacro", UrdfText(tree));
    WriteFileAtomically(directory / "sensors_macro.xacro", UrdfMacroText(tree));
    WriteCameraInfos(directory / "camera_info", result);
    WriteKalibrCamchain(directory / "kalibr_camchain.yaml", result);
    for (const ExportedFile& file : CorrectionFiles(result)) {
      WriteFileAtomically(directory / "corrections" / file.name, file.text);
    }
  }
  WriteCalibrationFile(directory / "calibration.yaml", result);
}

}  // namespace mlic
