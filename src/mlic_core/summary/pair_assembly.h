#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "mlic_core/initialization/lidars_alone.h"
#include "mlic_core/result/result.h"
#include "mlic_core/sensors/rig.h"
#include "mlic_core/uncertainty/adjustment.h"

namespace mlic {

// What is known of a camera against the root, of a small left rotation (rad) and translation (m) of
// T_root_camera.
struct CameraPlace {
  RigidTransform T_root_camera;
  Eigen::Matrix<double, 6, 6> claimed = Eigen::Matrix<double, 6, 6>::Zero();  // with the guess
  Eigen::Matrix<double, 6, 6> shown = Eigen::Matrix<double, 6, 6>::Zero();    // from the data alone
};

// How a camera's pose (a small left rotation, rad, and translation, m, of T_root_camera) and offset (s) err
// where its time offset was taken to be a second less than it is, in the mean over the trajectory without its
// ends.
Eigen::Matrix<double, 7, 1> ErrorOfOffset(const SplitSpline& T_map_root, const RigidTransform& T_root_camera);

// The pairs with at least one camera of alone.rig that are known well enough to be given. All cameras took
// part in the adjustment, which held their time offsets.
std::vector<PairResult> MakeCameraPairs(const LidarsAlone& alone, const Adjustment& adjustment);

// The pair of the root and a camera of a parked vehicle; nothing where it is hardly known.
std::optional<PairResult> MakeStillPair(const LidarsAlone& alone, std::size_t camera,
                                        const CameraPlace& place);

// rig: that of the whole. alone, adjustment: its LiDARs, adjusted without the IMU. of_cameras: the pairs
// with cameras. Makes a refused result one of pairs: partial, where they can be trusted (docs/method.md,
// section 12); else it stays refused, without pairs.
void AssemblePairs(const Rig& rig, const LidarsAlone& alone, const Adjustment& adjustment,
                   const std::vector<PairResult>& of_cameras, CalibrationResult* result);

}  // namespace mlic
