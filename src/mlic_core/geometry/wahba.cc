#include "mlic_core/geometry/wahba.h"

#include <Eigen/LU>
#include <Eigen/SVD>

namespace mlic {

Eigen::Matrix3d WahbaRotation(const Eigen::Matrix3d& profile, double* fit) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(profile, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0;
  const Eigen::Vector3d signs(1.0, 1.0, sign);
  if (fit != nullptr) *fit = signs.dot(svd.singularValues());
  return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

}  // namespace mlic
