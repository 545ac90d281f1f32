#pragma once

#include <Eigen/Core>
#include <optional>

#include "mlic_core/camera/tracks/image_pairs.h"
#include "mlic_core/camera/tracks/patch.h"

namespace mlic {

// The piece of surface about a landmark, taken for a plane, as one view, the reference, sees it. Between two
// views a piece that is seen obliquely, or far from the middle of a wide lens, is not related by an affine
// warp: over a patch of 15 px the rest is some hundredths of a pixel, the same for all patches of one part of
// the image, so that it does not average out but bends the calibration. With the predicted poses of the
// views it is known well enough.
class SurfacePiece {
 public:
  // point: the landmark, map frame; pixel: where the reference sees it. Nothing where the models do not
  // reach. The reference's intrinsics must outlive this.
  static std::optional<SurfacePiece> Make(const PredictedView& reference, const Eigen::Vector2d& pixel,
                                          const Eigen::Vector3d& point);

  // What an alignment in another view says of the slant: the affine part of the warp of pixels from the
  // reference to there, each element good to sigma.
  void AddWarp(const PredictedView& other, const Eigen::Matrix2d& affine, double sigma);
  // To be called after the last AddWarp.
  void EstimateSlant();

  // What the warp of a template, cut out about `pixel` of the reference in that level, into another view has
  // beyond its affine part. Nothing where the piece bends out of a view.
  std::optional<PatchBend> BendInto(const PredictedView& other, int level, double radius) const;

 private:
  PredictedView reference_;
  Eigen::Vector2d pixel_;
  Eigen::Vector3d ray_, across_, down_;  // unit, of the reference's frame: to the point, and its normals
  double range_ = 0.0;
  Eigen::Matrix<double, 3, 2> ray_by_pixel_;
  // The plane is all points range / (slant . d) along unit rays d: slant = n / (n . ray). Its parts along
  // across and down are estimated, from information and gradient.
  Eigen::Vector3d slant_;
  Eigen::Matrix2d information_;
  Eigen::Vector2d gradient_;
};

}  // namespace mlic
