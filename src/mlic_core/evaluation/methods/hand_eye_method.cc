#include "mlic_core/evaluation/methods/hand_eye_method.h"

#include "mlic_core/camera/features/feature_matcher.h"
#include "mlic_core/camera/tracks/tracks_from_images.h"
#include "mlic_core/evaluation/fresh_matches.h"
#include "mlic_core/evaluation/methods/camera_lever_arm.h"
#include "mlic_core/initialization/camera_rotation.h"
#include "mlic_core/initialization/drive_odometry.h"
#include "mlic_core/initialization/lidar_imu.h"
#include "mlic_core/initialization/pixel_matches.h"

namespace mlic {
namespace {

constexpr double kLargestError = 3.0;  // px, of a match; from: guard, as where a lens is given
constexpr double kLeastRotationShare =
    0.15;  // of motions that turn as the IMU; from: guard, as the calibration's

// Tracks of the camera with this index by itself, of each drive.
std::vector<TrackSet> OwnTracks(const Dataset& dataset, std::size_t camera, const SensorResult& lens,
                                const std::vector<const SplitSpline*>& T_map_imu,
                                const CancellationToken& cancellation) {
  std::vector<TrackSet> tracks;
  for (std::size_t d = 0; d < dataset.drives.size(); ++d) {
    const VehiclePose pose = [&](double time) -> std::optional<RigidTransform> {
      if (!T_map_imu[d]->Contains(time)) return std::nullopt;
      return T_map_imu[d]->Pose(time);
    };
    const TrackedCamera tracked{&dataset.drives[d].cameras[camera], *lens.intrinsics,
                                lens.rolling_shutter_readout.value_or(0.0)};
    tracks.push_back(FindTracks({tracked}, pose, {}, *MakeClassicalMatcher(), {}, {nullptr, &cancellation}));
  }
  return tracks;
}

// One camera on the trajectories; none where its images do not turn as the IMU does, or hardly move.
std::optional<SensorCalibration> AlignByMotion(const CameraConfig& config, const SensorResult& lens,
                                               const std::vector<TrackSet>& tracks,
                                               const std::vector<const SplitSpline*>& T_map_imu) {
  const std::vector<VisualMotion> motions =
      VisualMotions(MatchesOfKeyframes(tracks, 0), *lens.intrinsics, kLargestError);
  const CameraRotation rotation = AlignCameraRotation(motions, T_map_imu, config.guess, config.time_offset);
  if (!rotation.valid || rotation.inlier_share < kLeastRotationShare) return std::nullopt;
  const auto lever_arm =
      CameraLeverArm(motions, T_map_imu, rotation.R_imu_camera, rotation.time_offset, config.guess);
  if (!lever_arm) return std::nullopt;
  SensorCalibration found;
  found.T_imu_sensor = {rotation.R_imu_camera, *lever_arm};
  // Two views tell of the middle of an exposure; offsets belong to row 0.
  found.time_offset = rotation.time_offset - 0.5 * lens.rolling_shutter_readout.value_or(0.0);
  return found;
}

SensorResult Found(const std::string& name, const std::string& frame_id,
                   const SensorCalibration& calibration) {
  SensorResult sensor;
  sensor.name = name;
  sensor.frame_id = frame_id;
  sensor.calibration = calibration;
  return sensor;
}

void Reject(const std::string& name, SensorResult::Type type, CalibrationResult* result) {
  result->rejected.push_back({name, type, name + ": its motion does not agree with the IMU's"});
}

}  // namespace

CalibrationResult CalibrateByHandEye(const Rig& rig, const Dataset& dataset, const CalibrationResult& lenses,
                                     const CancellationToken& cancellation) {
  if (rig.lidars.empty()) {
    throw InputError(
        "hand-eye calibration needs a LiDAR in the rig: a camera alone does not show how far it moves");
  }
  CalibrationResult result;
  result.imu_frame_id = rig.imu.frame_id;
  result.reasons = {"hand-eye calibration: for comparison, not for use"};
  std::vector<DriveOdometry> odometry;
  for (const Drive& drive : dataset.drives) {
    odometry.push_back(RunDriveOdometry(rig, drive, cancellation, [](double) {}));
  }
  const Initialization start = Initialize(rig, dataset, odometry, cancellation);
  result.reasons.insert(result.reasons.end(), start.problems.begin(), start.problems.end());
  if (start.state.drives.size() < dataset.drives.size()) return result;
  for (std::size_t l = 0; l < rig.lidars.size(); ++l) {
    const LidarConfig& config = rig.lidars[l];
    if (start.loose[l] || start.unaligned[l]) {
      Reject(config.name, SensorResult::Type::kLidar, &result);
    } else {
      result.sensors.push_back(Found(config.name, config.frame_id, start.state.lidars[l]));
    }
  }
  std::vector<const SplitSpline*> T_map_imu;
  for (const DriveState& drive : start.state.drives) T_map_imu.push_back(&drive.trajectory);
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    const CameraConfig& config = rig.cameras[c];
    const SensorResult* lens = FindCamera(lenses, config.name);
    if (lens == nullptr) continue;
    const auto found =
        AlignByMotion(config, *lens, OwnTracks(dataset, c, *lens, T_map_imu, cancellation), T_map_imu);
    if (!found) {
      Reject(config.name, SensorResult::Type::kCamera, &result);
      continue;
    }
    SensorResult camera = Found(config.name, config.frame_id, *found);
    camera.type = SensorResult::Type::kCamera;
    camera.intrinsics = lens->intrinsics;
    camera.rolling_shutter_readout = lens->rolling_shutter_readout;
    result.sensors.push_back(std::move(camera));
  }
  return result;
}

}  // namespace mlic
