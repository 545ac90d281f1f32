#include "mlic_core/camera/tracks/patch_surface.h"

#include <Eigen/LU>
#include <cmath>

namespace mlic {
namespace {

// Tangents of angles of incidence, before anything is known of a surface. from: guard, wide: 72 deg.
constexpr double kUsualSlant = 3.0;
// Planes are not seen more obliquely than that: the piece would bend out of sight. from: guard, division by
// it.
constexpr double kLeastDepthRatio = 0.2;

}  // namespace

std::optional<SurfacePiece> SurfacePiece::Make(const PredictedView& reference, const Eigen::Vector2d& pixel,
                                               const Eigen::Vector3d& point) {
  SurfacePiece piece;
  piece.reference_ = reference;
  piece.pixel_ = pixel;
  const Eigen::Vector3d in_camera = reference.T_map_camera.Inverse() * point;
  piece.range_ = in_camera.norm();
  Eigen::Vector2d projected;
  CameraPointJacobian J;
  if (!Unproject(*reference.intrinsics, pixel, &piece.ray_) ||
      !Project(*reference.intrinsics, piece.ray_, &projected, &J)) {
    return std::nullopt;
  }
  piece.across_ = piece.ray_.unitOrthogonal();
  piece.down_ = piece.ray_.cross(piece.across_);
  Eigen::Matrix<double, 3, 2> axes;
  axes << piece.across_, piece.down_;
  const Eigen::Matrix2d J_axes = J * axes;
  if (!(std::abs(J_axes.determinant()) > 1.0)) return std::nullopt;
  piece.ray_by_pixel_ = axes * J_axes.inverse();
  piece.slant_ = piece.ray_;
  piece.information_ = Eigen::Matrix2d::Identity() / (kUsualSlant * kUsualSlant);
  piece.gradient_.setZero();
  return piece;
}

// A step du of the pixel moves the point of the plane by range (I - ray slant^T) ray_by_pixel du: the warp is
// linear in the slant.
void SurfacePiece::AddWarp(const PredictedView& other, const Eigen::Matrix2d& affine, double sigma) {
  const RigidTransform T_other_reference = other.T_map_camera.Inverse() * reference_.T_map_camera;
  Eigen::Vector2d projected;
  CameraPointJacobian J;
  if (!Project(*other.intrinsics, T_other_reference * Eigen::Vector3d(range_ * ray_), &projected, &J)) return;
  const CameraPointJacobian by_point = range_ * J * T_other_reference.rotation.toRotationMatrix();
  const Eigen::Matrix2d missing = affine - by_point * ray_by_pixel_;
  const Eigen::Vector2d along = -by_point * ray_;
  const Eigen::RowVector2d by_across = across_.transpose() * ray_by_pixel_;
  const Eigen::RowVector2d by_down = down_.transpose() * ray_by_pixel_;
  const double weight = 1.0 / (sigma * sigma * affine.squaredNorm());
  Eigen::Matrix<double, 4, 2> jacobian;
  jacobian << along * by_across[0], along * by_down[0], along * by_across[1], along * by_down[1];
  const Eigen::Vector4d wanted(missing(0, 0), missing(1, 0), missing(0, 1), missing(1, 1));
  information_ += weight * jacobian.transpose() * jacobian;
  gradient_ += weight * jacobian.transpose() * wanted;
}

void SurfacePiece::EstimateSlant() {
  const Eigen::Vector2d slant = information_.inverse() * gradient_;
  slant_ = ray_ + slant[0] * across_ + slant[1] * down_;
}

std::optional<PatchBend> SurfacePiece::BendInto(const PredictedView& other, int level, double radius) const {
  const RigidTransform T_other_reference = other.T_map_camera.Inverse() * reference_.T_map_camera;
  const double step = 0.6 * radius;  // px of the level
  Eigen::Vector2d at[3][3];          // by row and column
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      const Eigen::Vector2d offset = step * (1 << level) * Eigen::Vector2d(column - 1, row - 1);
      Eigen::Vector3d ray;
      if (!Unproject(*reference_.intrinsics, pixel_ + offset, &ray)) return std::nullopt;
      const double depth_ratio = slant_.dot(ray);
      if (!(depth_ratio > kLeastDepthRatio)) return std::nullopt;
      const Eigen::Vector3d point = range_ / depth_ratio * ray;
      if (!Project(*other.intrinsics, T_other_reference * point, &at[row][column])) return std::nullopt;
    }
  }
  const Eigen::Vector2d& middle = at[1][1];
  Eigen::Matrix2d affine;
  affine << (at[1][2] - at[1][0]) / (2.0 * step), (at[2][1] - at[0][1]) / (2.0 * step);
  if (!(std::abs(affine.determinant()) > 1e-6)) return std::nullopt;
  Eigen::Matrix<double, 2, 3> second;
  second << 0.5 * (at[1][2] - 2.0 * middle + at[1][0]), 0.25 * (at[2][2] - at[2][0] - at[0][2] + at[0][0]),
      0.5 * (at[2][1] - 2.0 * middle + at[0][1]);
  return PatchBend((affine.inverse() * second / (step * step)).cast<float>());
}

}  // namespace mlic
