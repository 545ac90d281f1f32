#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "mlic_core/initialization/lidars_alone.h"
#include "mlic_core/result/result.h"
#include "mlic_core/sensors/rig.h"
#include "mlic_core/uncertainty/adjustment.h"

namespace mlic {

// sigmas that the last round may have moved pairs by: theirs contain it. from: definition
constexpr double kLargestChangeOfPairs = 3.0;

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

// The pairs of LiDARs that the adjustment without the IMU knows well enough to be given.
std::vector<PairResult> MakeLidarPairs(const LidarsAlone& alone, const Adjustment& adjustment);

// What a refused calibration with the IMU shows of its sensors to each other, without the guesses: its
// result's pairs, where it stood still. whole: as it ended; null: it has not come that far.
std::vector<PairResult> PairsOfRefused(const Adjustment* whole, const CalibrationResult& result);

// The LiDAR with most pairs, of several the preferred or the first; nothing: no pair has a LiDAR.
std::optional<std::string> RootOf(const Rig& rig, const std::vector<PairResult>& pairs,
                                  const std::string& preferred = "");

inline bool Has(const PairResult& pair, const std::string& sensor) {
  return pair.a == sensor || pair.b == sensor;
}

// Whether every sensor of the rig is in a pair with the root.
bool TieAll(const Rig& rig, const std::string& root, const std::vector<PairResult>& pairs);

// Whether the adjustment stood still, on planes enough (docs/method.md, section 12).
bool CanGivePairs(const Adjustment& adjustment);

// Makes a refused result one of pairs: partial, where the adjustment that they are from can be trusted
// (docs/method.md, section 12) and one has the root; else it stays refused, without pairs.
void AssemblePairs(const Rig& rig, const std::string& root, const Adjustment& adjustment,
                   std::vector<PairResult> pairs, CalibrationResult* result);

}  // namespace mlic
