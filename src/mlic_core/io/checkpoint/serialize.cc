#include "mlic_core/io/checkpoint/serialize.h"

#include "mlic_core/io/checkpoint/archive_types.h"

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
template <>
struct IsFlat<HeldOutMatches> : std::true_type {};
template <>
struct IsFlat<PoseOverGround> : std::true_type {};

auto Members(LidarScan& scan) { return std::tie(scan.time, scan.points); }
auto Members(LidarRecording& recording) {
  return std::tie(recording.scans, recording.scan_period, recording.point_times_from_azimuth);
}

auto Members(Drive& drive) { return std::tie(drive.epoch, drive.imu, drive.lidars); }
auto Members(Dataset& dataset) { return std::tie(dataset.drives); }

auto Members(SigmaInUse& sigma) {
  return std::tie(sigma.where, sigma.distance, sigma.median, sigma.worst, sigma.sectors);
}
auto Members(SensorResult& sensor) {
  return std::tie(sensor.name, sensor.type, sensor.frame_id, sensor.fixed, sensor.topic, sensor.calibration,
                  sensor.sigma, sensor.translation_observable, sensor.rotation_observable,
                  sensor.time_offset_observable, sensor.drift_sigma, sensor.clock_reference,
                  sensor.unobservable, sensor.intrinsics, sensor.intrinsics_sigma, sensor.intrinsics_fixed,
                  sensor.rolling_shutter_readout, sensor.readout_sigma, sensor.held_out, sensor.in_use);
}

auto Members(PairResult& pair) {
  return std::tie(pair.a, pair.b, pair.T_a_b, pair.sigma, pair.unobservable, pair.in_use);
}
auto Members(StageSummary& stage) {
  return std::tie(stage.name, stage.seconds, stage.processor_seconds, stage.lines);
}

auto Members(ResidualField& field) { return std::tie(field.columns, field.rows, field.mean, field.counts); }
auto Members(ResidualSummary& residual) {
  return std::tie(residual.sensor, residual.unit, residual.sigma, residual.inlier_share, residual.histogram,
                  residual.over_time_seconds, residual.over_time_rms, residual.rms, residual.over_image,
                  residual.drift);
}

auto Members(CameraKeyframes& keyframes) { return std::tie(keyframes.camera, keyframes.stamps); }
auto Members(QualityCheck& check) {
  return std::tie(check.name, check.sensor, check.value, check.limit, check.unit, check.bound, check.refuses,
                  check.failure, check.remedy);
}
auto Members(RejectedSensor& sensor) {
  return std::tie(sensor.name, sensor.type, sensor.reason, sensor.frame_id);
}
auto Members(CalibrationResult& result) {
  return std::tie(result.verdict, result.reasons, result.rejected, result.warnings, result.checks,
                  result.imu_frame_id, result.imu, result.gravity, result.sensors, result.initial_sensors,
                  result.pairs, result.ground, result.root, result.trajectories, result.map, result.stages,
                  result.residuals, result.keyframes, result.peak_memory_megabytes);
}

std::vector<char> ToBytes(const Dataset& dataset) { return WrittenBytes(dataset); }
std::vector<char> ToBytes(const CalibrationResult& result) { return WrittenBytes(result); }

bool FromBytes(const std::vector<char>& bytes, Dataset* dataset) { return ReadBytes(bytes, dataset); }
bool FromBytes(const std::vector<char>& bytes, CalibrationResult* result) { return ReadBytes(bytes, result); }

}  // namespace mlic
