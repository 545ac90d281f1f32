#pragma once

#include <Eigen/Core>
#include <vector>

#include "mlic_core/crossmodal/structure_score.h"

namespace mlic {

struct StructureAlignmentOptions {
  std::vector<int> widths{384, 576, 960};  // px, of the shrunk photos, one after the other
  int rounds = 3;                          // of rendering and climbing at each; from: guard, time
  std::size_t candidates = 8;  // peaks of the grid that are climbed at the first; from: guard, time
  std::size_t kept = 3;        // the best of them, climbed at the second; from: guard, time
};

constexpr double kAwayDegrees = 4.0;  // from: definition, StructureAlignment::elsewhere

struct StructureAlignment {
  RigidTransform T_body_camera;
  // Of a small rotation (rad, left) and translation (m) of T_camera_body; prior included.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Zero();  // of the data alone
  double score_before = 0.0, score_after = 0.0;                                   // at the last size
  double elsewhere = 0.0;         // the highest score at poses turned away by kAwayDegrees
  double squared_distance = 0.0;  // from the start, of the prior's covariance
  double last_scale = 1.0;        // of the photos' sizes
};

// The pose that maximises correlation times weight of StructureScore, coarse to fine, with a Gaussian prior
// about the start: first the peaks of a grid of rotations within 2.5 sigmas and Newton steps of the rotation,
// then Newton steps of both. prior: covariance as CameraUncertainty's pose. Does not depend on the number of
// threads.
StructureAlignment AlignByStructure(const std::vector<StillPair>& pairs, const CameraIntrinsics& intrinsics,
                                    const RigidTransform& T_body_camera,
                                    const Eigen::Matrix<double, 6, 6>& prior,
                                    const StructureAlignmentOptions& options);

}  // namespace mlic
