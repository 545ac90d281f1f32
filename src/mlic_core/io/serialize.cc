#include "mlic_core/io/serialize.h"

#include "mlic_core/io/archive_types.h"

namespace mlic {

template <>
struct IsFlat<ImuCalibration> : std::true_type {};
template <>
struct IsFlat<ImuSample> : std::true_type {};
template <>
struct IsFlat<LidarPoint> : std::true_type {};
template <>
struct IsFlat<StampedPose> : std::true_type {};
template <>
struct IsFlat<MapPoint> : std::true_type {};
template <>
struct IsFlat<UnobservableDirection> : std::true_type {};

template <typename Archive>
void Fields(Archive& archive, LidarScan& scan) {
  archive(scan.time, scan.points);
}

template <typename Archive>
void Fields(Archive& archive, LidarRecording& recording) {
  archive(recording.scans, recording.scan_period, recording.point_times_from_azimuth);
}

template <typename Archive>
void Fields(Archive& archive, Drive& drive) {
  archive(drive.epoch, drive.imu, drive.lidars);
}

template <typename Archive>
void Fields(Archive& archive, Dataset& dataset) {
  archive(dataset.drives);
}

template <typename Archive>
void Fields(Archive& archive, SensorResult& sensor) {
  // A vector of bools has no array of bytes to copy.
  std::vector<std::uint8_t> held(sensor.intrinsics_held.begin(), sensor.intrinsics_held.end());
  archive(sensor.name, sensor.type, sensor.frame_id, sensor.topic, sensor.calibration, sensor.sigma,
          sensor.translation_observable, sensor.rotation_observable, sensor.time_offset_observable,
          sensor.unobservable, sensor.intrinsics, sensor.intrinsics_sigma, held,
          sensor.rolling_shutter_readout, sensor.readout_sigma);
  sensor.intrinsics_held.assign(held.begin(), held.end());
}

template <typename Archive>
void Fields(Archive& archive, PairResult& pair) {
  archive(pair.a, pair.b, pair.T_a_b, pair.sigma);
}

template <typename Archive>
void Fields(Archive& archive, StageSummary& stage) {
  archive(stage.name, stage.seconds, stage.lines);
}

template <typename Archive>
void Fields(Archive& archive, ResidualField& field) {
  archive(field.columns, field.rows, field.mean, field.counts);
}

template <typename Archive>
void Fields(Archive& archive, ResidualSummary& residual) {
  archive(residual.sensor, residual.unit, residual.sigma, residual.inlier_share, residual.histogram,
          residual.over_time_seconds, residual.over_time_rms, residual.rms, residual.over_image);
}

template <typename Archive>
void Fields(Archive& archive, CameraKeyframes& keyframes) {
  archive(keyframes.camera, keyframes.stamps);
}

template <typename Archive>
void Fields(Archive& archive, CalibrationResult& result) {
  archive(result.trusted, result.reasons, result.warnings, result.imu_frame_id, result.imu, result.gravity,
          result.sensors, result.initial_sensors, result.pairs, result.trajectories, result.map,
          result.stages, result.residuals, result.keyframes, result.peak_memory_megabytes);
}

std::vector<char> ToBytes(const Dataset& dataset) { return WrittenBytes(dataset); }
std::vector<char> ToBytes(const std::vector<OdometryResult>& odometry) { return WrittenBytes(odometry); }
std::vector<char> ToBytes(const CalibrationResult& result) { return WrittenBytes(result); }

bool FromBytes(const std::vector<char>& bytes, Dataset* dataset) { return ReadBytes(bytes, dataset); }
bool FromBytes(const std::vector<char>& bytes, std::vector<OdometryResult>* odometry) {
  return ReadBytes(bytes, odometry);
}
bool FromBytes(const std::vector<char>& bytes, CalibrationResult* result) { return ReadBytes(bytes, result); }

}  // namespace mlic
