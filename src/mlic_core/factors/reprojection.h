#pragma once

#include <Eigen/Core>

#include "mlic_core/sensors/camera_model.h"
#include "mlic_core/trajectory/split_spline.h"

namespace mlic {

// The camera residual (docs/method.md, section 3.3), with its Jacobians in one pass:
//   r = project(R_imu_camera^T (R(t)^T (P - p(t)) - p_imu_camera)) - uv,
//   t = SensorCalibration::OnImuClock(stamp) + (v / height) * readout
// in pixels, not whitened. The row v of a rolling shutter is the measured one, so t hangs on no other
// unknown. Columns: 4 rotation control points (right perturbations, 12), 4 position control points (12),
// extrinsic rotation (left perturbation, 3), extrinsic translation (3), time offset (1), readout (1), the
// point P in the map frame (3), intrinsics (as many as the model has; the rest of the 12 are zero). One
// residual's derivatives lie together in memory.
struct Reprojection {
  static constexpr int kRotation = 0;                                   // from: structural, places of columns
  static constexpr int kPosition = 12;                                  // from: structural, places of columns
  static constexpr int kExtrinsic = 24;                                 // from: structural, places of columns
  static constexpr int kTimeOffset = 30;                                // from: structural, places of columns
  static constexpr int kReadout = 31;                                   // from: structural, places of columns
  static constexpr int kPoint = 32;                                     // from: structural, places of columns
  static constexpr int kIntrinsics = 35;                                // from: structural, places of columns
  static constexpr int kColumns = kIntrinsics + kMostCameraParameters;  // from: structural, places of columns
  using Jacobian = Eigen::Matrix<double, kColumns, 2>;                  // column k: of residual k

  Eigen::Vector2d pixel;   // uv as measured
  double row_share = 0.0;  // v / height

  struct Camera {
    Eigen::Matrix3d R_imu_camera;
    Eigen::Vector3d p_imu_camera;
    const CameraIntrinsics* intrinsics = nullptr;
  };

  static Reprojection Of(const Eigen::Vector2d& pixel, const CameraIntrinsics& intrinsics) {
    return {pixel, pixel.y() / intrinsics.height};
  }

  // When the pixel was exposed, after row 0; readout 0 for a global shutter. Both on the IMU's clock.
  double Time(double first_row, double readout) const { return first_row + row_share * readout; }

  // Bases at Time(...). False where the camera cannot see P: then nothing is written.
  bool Evaluate(const SplitSpline& trajectory, const SplineBasis& rotation_basis,
                const SplineBasis& position_basis, const Camera& camera, const Eigen::Vector3d& P,
                Eigen::Vector2d* residual, Jacobian* jacobian = nullptr) const {
    const Eigen::Vector3d from_imu = P - trajectory.position.Position(position_basis);
    So3Spline::Jacobians J;
    const So3Spline::Value rotation = jacobian != nullptr
                                          ? trajectory.rotation.Evaluate(rotation_basis, false, &J)
                                          : trajectory.rotation.Evaluate(rotation_basis);
    const Eigen::Vector3d y = rotation.rotation.transpose() * from_imu;
    const Eigen::Vector3d z = y - camera.p_imu_camera;
    CameraPointJacobian J_point;
    CameraParameterJacobian J_intrinsics;
    Eigen::Vector2d projected;
    if (!Project(*camera.intrinsics, camera.R_imu_camera.transpose() * z, &projected,
                 jacobian != nullptr ? &J_point : nullptr, jacobian != nullptr ? &J_intrinsics : nullptr)) {
      return false;
    }
    *residual = projected - pixel;
    if (jacobian == nullptr) return true;
    const Eigen::Vector3d y_dot =
        y.cross(rotation.angular_velocity) -
        rotation.rotation.transpose() * trajectory.position.Velocity(position_basis);
    const Eigen::Vector4d weights = SplineBasis::Weights(position_basis.lambda);
    for (int k = 0; k < 2; ++k) {
      const Eigen::Vector3d by_y = camera.R_imu_camera * J_point.row(k).transpose();
      const Eigen::Vector3d by_P = rotation.rotation * by_y;
      const Eigen::Vector3d by_rotation = by_y.cross(y);
      auto out = jacobian->col(k);
      for (int j = 0; j < 4; ++j) {
        out.segment<3>(kRotation + 3 * j).noalias() = J.rotation[j].transpose() * by_rotation;
        out.segment<3>(kPosition + 3 * j) = -weights[j] * by_P;
      }
      out.segment<3>(kExtrinsic) = by_y.cross(z);
      out.segment<3>(kExtrinsic + 3) = -by_y;
      out[kTimeOffset] = by_y.dot(y_dot);
      out[kReadout] = row_share * out[kTimeOffset];
      out.segment<3>(kPoint) = by_P;
      const int intrinsics = static_cast<int>(J_intrinsics.cols());
      for (int i = 0; i < intrinsics; ++i) out[kIntrinsics + i] = J_intrinsics(k, i);
      for (int i = intrinsics; i < kMostCameraParameters; ++i) out[kIntrinsics + i] = 0.0;
    }
    return true;
  }
};

}  // namespace mlic
