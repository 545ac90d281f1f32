#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "mlic_core/crossmodal/camera_to_map.h"
#include "mlic_core/crossmodal/structure_alignment.h"

namespace mlic {

// Where a camera sits on a body, from photos and what the LiDARs saw about each of them.
struct StillAlignment {
  RigidTransform T_body_camera;
  // Of a small rotation (rad, left) and translation (m) of T_camera_body; with the prior, and its inverse
  // without.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Zero();
  StructureAlignment found;                  // by all pixels together
  std::optional<CameraToMapResult> refined;  // by single matches, where they say more; it is the pose then

  // Why the photos do not show the LiDARs' structure at one clear place, or how the guess contradicts it;
  // empty: they do.
  std::string Doubt() const;
};

// By structure from the start on, and by single matches where one pair is dense enough for them. prior: as of
// AlignByStructure.
StillAlignment AlignStill(const std::vector<StillPair>& pairs, const CameraIntrinsics& intrinsics,
                          const RigidTransform& T_body_camera, const Eigen::Matrix<double, 6, 6>& prior);

// Covariance of a small left rotation and translation of T from that of the inverse of T.
Eigen::Matrix<double, 6, 6> CovarianceOfInverse(const RigidTransform& T,
                                                const Eigen::Matrix<double, 6, 6>& covariance);

}  // namespace mlic
