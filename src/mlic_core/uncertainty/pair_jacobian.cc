#include "mlic_core/uncertainty/pair_jacobian.h"

#include "mlic_core/geometry/so3.h"

namespace mlic {

Eigen::Matrix<double, 7, 14> PairJacobian(const SensorCalibration& a, const SensorCalibration& b) {
  const Eigen::Matrix3d R_a_imu = a.T_imu_sensor.rotation.conjugate().toRotationMatrix();
  // Left perturbations phi of the rotations and moves of the translations, carried into frame a:
  //   rotation R_a^T (phi_b - phi_a), translation R_a^T (d_b - d_a + (p_b - p_a) x phi_a).
  Eigen::Matrix<double, 7, 14> J = Eigen::Matrix<double, 7, 14>::Zero();
  J.block<3, 3>(0, 0) = -R_a_imu;
  J.block<3, 3>(0, 7) = R_a_imu;
  J.block<3, 3>(3, 0) = R_a_imu * Hat(b.T_imu_sensor.translation - a.T_imu_sensor.translation);
  J.block<3, 3>(3, 3) = -R_a_imu;
  J.block<3, 3>(3, 10) = R_a_imu;
  J(6, 6) = -1.0;
  J(6, 13) = 1.0;
  return J;
}

}  // namespace mlic
