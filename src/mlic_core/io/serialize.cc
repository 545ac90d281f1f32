#include "mlic_core/io/serialize.h"

#include "mlic_core/io/byte_archive.h"

namespace mlic {

template <typename Scalar, int Rows, int Columns>
struct IsFlat<Eigen::Matrix<Scalar, Rows, Columns>> : std::integral_constant<bool, Rows != Eigen::Dynamic> {};
template <>
struct IsFlat<RigidTransform> : std::true_type {};
template <>
struct IsFlat<SensorCalibration> : std::true_type {};
template <>
struct IsFlat<ImuCalibration> : std::true_type {};
template <>
struct IsFlat<ImuSample> : std::true_type {};
template <>
struct IsFlat<LidarPoint> : std::true_type {};
template <>
struct IsFlat<OdometryPose> : std::true_type {};
template <>
struct IsFlat<StampedPose> : std::true_type {};
template <>
struct IsFlat<MapPoint> : std::true_type {};
template <>
struct IsFlat<PoseSigma> : std::true_type {};
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
void Fields(Archive& archive, OdometryResult& odometry) {
  archive(odometry.poses);
}

template <typename Archive>
void Fields(Archive& archive, CameraIntrinsics& intrinsics) {
  archive(intrinsics.model, intrinsics.width, intrinsics.height, intrinsics.parameters);
}

template <typename Archive>
void Fields(Archive& archive, SensorResult& sensor) {
  archive(sensor.name, sensor.type, sensor.frame_id, sensor.calibration, sensor.sigma,
          sensor.translation_observable, sensor.rotation_observable, sensor.time_offset_observable,
          sensor.unobservable, sensor.intrinsics, sensor.rolling_shutter_readout);
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
void Fields(Archive& archive, ResidualSummary& residual) {
  archive(residual.sensor, residual.unit, residual.sigma, residual.inlier_share, residual.histogram,
          residual.over_time_seconds, residual.over_time_rms);
}

template <typename Archive>
void Fields(Archive& archive, CalibrationResult& result) {
  archive(result.trusted, result.reasons, result.warnings, result.imu_frame_id, result.imu, result.gravity,
          result.sensors, result.pairs, result.trajectories, result.map, result.stages, result.residuals,
          result.peak_memory_megabytes);
}

namespace {

template <typename T>
std::vector<char> Written(const T& value) {
  ByteWriter writer;
  writer(value);
  return writer.Take();
}

template <typename T>
bool Read(const std::vector<char>& bytes, T* value) {
  ByteReader reader(bytes);
  reader(*value);
  return reader.Complete();
}

}  // namespace

std::vector<char> ToBytes(const Dataset& dataset) { return Written(dataset); }
std::vector<char> ToBytes(const std::vector<OdometryResult>& odometry) { return Written(odometry); }
std::vector<char> ToBytes(const CalibrationResult& result) { return Written(result); }

bool FromBytes(const std::vector<char>& bytes, Dataset* dataset) { return Read(bytes, dataset); }
bool FromBytes(const std::vector<char>& bytes, std::vector<OdometryResult>* odometry) {
  return Read(bytes, odometry);
}
bool FromBytes(const std::vector<char>& bytes, CalibrationResult* result) { return Read(bytes, result); }

}  // namespace mlic
