#include "ceres_reference/manifolds.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "ceres_reference/evaluation_point.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/problem/landmark_terms.h"
#include "mlic_core/problem/plane_terms.h"

namespace mlic::ceres_reference {

using ConstQuaternion = Eigen::Map<const Eigen::Quaterniond>;
using ConstVector = Eigen::Map<const Eigen::Vector3d>;

namespace {

// The identity plus a lower triangle, row by row.
Eigen::Matrix3d Deformation(const double* step) {
  Eigen::Matrix3d triangle = Eigen::Matrix3d::Identity();
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c <= r; ++c) triangle(r, c) += *step++;
  }
  return triangle;
}

}  // namespace

void PlusRight(const double* x, const double* step, double* moved) {
  Eigen::Map<Eigen::Quaterniond> out(moved);
  out = (ConstQuaternion(x) * ExpQuaternion(ConstVector(step))).normalized();
}

void PlusLeft(const double* x, const double* step, double* moved) {
  Eigen::Map<Eigen::Quaterniond> out(moved);
  out = (ExpQuaternion(ConstVector(step)) * ConstQuaternion(x)).normalized();
}

void PlusAlignment(const double* x, const double* step, double* moved) {
  Eigen::Map<Eigen::Matrix3d> out(moved);
  out = ExpMatrix(Eigen::Map<const Eigen::Vector3d>(step)) * Eigen::Map<const Eigen::Matrix3d>(x);
}

void PlusAccelerometer(const double* x, const double* step, double* moved) {
  PlusAlignment(x, step, moved);
  Eigen::Map<Eigen::Matrix3d> out(moved);
  out = (out * Deformation(step + 3)).eval();
}

void PlusGyroscope(const double* x, const double* step, double* moved) {
  const Eigen::Map<const Eigen::Matrix3d> matrix(x);
  Eigen::Map<Eigen::Matrix3d> out(moved);
  out = (Deformation(step) * matrix).eval();
}

void PlusPlane(const double* x, const double* step, double* moved) {
  MapPlane plane = PlaneOf(x);
  MovePlane(ConstVector(step), &plane);
  const PlaneBlock block = BlockOf(plane);
  std::copy(block.begin(), block.end(), moved);
}

void PlusPoint(const double* x, const double* step, double* moved) {
  PointLandmark point = PointOf(x);
  MovePoint(ConstVector(step), &point);
  const PointBlock block = BlockOf(point);
  std::copy(block.begin(), block.end(), moved);
}

bool LiftedManifold::Lift(double* jacobian) const {
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  Eigen::Map<RowMajor>(jacobian, ambient_, tangent_).setIdentity();
  return true;
}

}  // namespace mlic::ceres_reference
