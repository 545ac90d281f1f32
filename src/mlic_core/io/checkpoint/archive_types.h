#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "mlic_core/geometry/timed_pose.h"
#include "mlic_core/io/checkpoint/byte_archive.h"
#include "mlic_core/result/result.h"
#include "mlic_core/sensors/rig.h"

namespace mlic {

// How types that several checkpoints hold are archived, and objects as a whole.

template <typename Scalar, int Rows, int Columns>
struct IsFlat<Eigen::Matrix<Scalar, Rows, Columns>> : std::integral_constant<bool, Rows != Eigen::Dynamic> {};
template <>
struct IsFlat<Eigen::Quaterniond> : std::true_type {};
template <>
struct IsFlat<RigidTransform> : std::true_type {};
template <>
struct IsFlat<TimedPose> : std::true_type {};
template <>
struct IsFlat<PoseSigma> : std::true_type {};

inline auto Members(SensorCalibration& sensor) {
  return std::tie(sensor.T_imu_sensor, sensor.time_offset, sensor.clock_drift);
}
inline auto Members(CameraIntrinsics& intrinsics) {
  return std::tie(intrinsics.model, intrinsics.width, intrinsics.height, intrinsics.parameters);
}

template <typename T>
std::vector<char> WrittenBytes(const T& value) {
  ByteWriter writer;
  writer(value);
  return writer.Take();
}

// False when the bytes are not exactly one such object.
template <typename T>
bool ReadBytes(const std::vector<char>& bytes, T* value) {
  ByteReader reader(bytes);
  reader(*value);
  return reader.Complete();
}

}  // namespace mlic
