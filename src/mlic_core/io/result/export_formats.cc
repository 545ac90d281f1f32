#include "mlic_core/io/result/export_formats.h"

#include <algorithm>

#include "mlic_core/io/result/autoware.h"
#include "mlic_core/io/result/camera_info.h"
#include "mlic_core/io/result/correction_files.h"
#include "mlic_core/io/result/kalibr_camchain.h"
#include "mlic_core/io/result/lidar_odometry_configs.h"
#include "mlic_core/io/result/opencv_cameras.h"
#include "mlic_core/io/result/static_transforms.h"
#include "mlic_core/io/result/urdf.h"
#include "mlic_core/io/result/vins_fusion.h"

namespace mlic {
namespace {

using Place = ExportFormat::Place;

// A format with one file of poses.
ExportFormat OfSensorTree(
    const std::string& name, Place place,
    const std::function<std::string(const CalibrationResult&, const SensorTree&)>& text) {
  return {name, place, false, "a sensor beside the parent",
          [text](const CalibrationResult& result, const SensorTree& tree) {
            return tree.frames.empty() ? std::vector<ExportedFile>()
                                       : std::vector<ExportedFile>{{"", text(result, tree)}};
          }};
}

// The same, which need not know what the frames are of.
ExportFormat OfTree(const std::string& name, Place place,
                    const std::function<std::string(const SensorTree&)>& text) {
  return OfSensorTree(name, place, [text](const CalibrationResult& /*result*/, const SensorTree& tree) {
    return text(tree);
  });
}

// A format with one file that is empty where the calibration has nothing for it.
ExportFormat OfCameras(const std::string& name,
                       const std::function<std::string(const CalibrationResult&)>& text) {
  return {name, Place::kNone, false, "a camera that is tied to the IMU",
          [text](const CalibrationResult& result, const SensorTree& /*tree*/) {
            const std::string whole = text(result);
            return whole.empty() ? std::vector<ExportedFile>() : std::vector<ExportedFile>{{"", whole}};
          }};
}

// A format with several files.
ExportFormat InDirectory(const std::string& name, const std::string& needs,
                         const std::function<std::vector<ExportedFile>(const CalibrationResult&)>& files) {
  return {name, Place::kNone, true, needs,
          [files](const CalibrationResult& result, const SensorTree& /*tree*/) { return files(result); }};
}

std::vector<ExportedFile> CameraInfoFiles(const CalibrationResult& result) {
  std::vector<ExportedFile> files;
  for (const SensorResult& sensor : result.sensors) {
    const std::string text = CameraInfoText(sensor);
    if (!text.empty()) files.push_back({sensor.name + ".yaml", text});
  }
  return files;
}

}  // namespace

const std::vector<ExportFormat>& ExportFormats() {
  static const std::vector<ExportFormat> formats{
      OfTree("tf2", Place::kBesideModel,
             [](const SensorTree& tree) { return StaticTransformsText(tree, TransformPublisher::kTf2); }),
      OfTree("tf", Place::kBesideModel,
             [](const SensorTree& tree) { return StaticTransformsText(tree, TransformPublisher::kTf); }),
      OfTree("urdf", Place::kRobot, UrdfText),
      OfTree("xacro", Place::kBesideModel, UrdfMacroText),
      OfTree("autoware", Place::kTree, AutowareText),
      OfSensorTree("isaac", Place::kTree, IsaacUrdfText),
      InDirectory("camera_info", "a camera of a model that CameraInfo has", CameraInfoFiles),
      OfCameras("opencv", OpenCvCamerasText),
      OfCameras("kalibr",
                [](const CalibrationResult& result) {
                  return KalibrCamchainText(result, CamchainReader::kKalibr);
                }),
      OfCameras("openvins",
                [](const CalibrationResult& result) {
                  return KalibrCamchainText(result, CamchainReader::kOpenVins);
                }),
      InDirectory("rings", "a LiDAR whose points were corrected", CorrectionFiles),
      InDirectory("vins_fusion", "a camera that is tied to the IMU", VinsFusionFiles),
      InDirectory("fast_lio", "a LiDAR that is tied to the IMU", FastLioFiles),
      InDirectory("lio_sam", "a LiDAR that is tied to the IMU", LioSamFiles),
      InDirectory("fast_livo2", "a LiDAR and a camera that are tied to the IMU", FastLivo2Files),
  };
  return formats;
}

const ExportFormat& ExportFormatNamed(const std::string& name) {
  return *std::find_if(ExportFormats().begin(), ExportFormats().end(),
                       [&](const ExportFormat& format) { return format.name == name; });
}

}  // namespace mlic
