#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "mlic_core/camera/features/feature_matcher.h"
#include "mlic_core/result/result.h"

namespace mlic {

// Where the intrinsics of cameras start that the rig file gives none of.
enum class IntrinsicsStart {
  kTrajectory,  // the field of view; rotation, then triangulation on the trajectory do the rest
  kColmap       // COLMAP on each camera alone, from the field of view
};

// What the user may choose. Everything else is measured from the data.
struct CalibrationOptions {
  IntrinsicsStart intrinsics = IntrinsicsStart::kTrajectory;
  std::shared_ptr<const FeatureMatcher> matcher;  // null: the classical one
  std::filesystem::path colmap_directory;         // for COLMAP's files; empty: in the system's temporary one
  // For a check of an earlier calibration, in seconds: where its sensors are is found anew, and what moves of
  // itself hardly ever, intrinsics, readouts and the IMU's matrices, is held as it has them. Few keyframes
  // are taken, and photos are not matched with the LiDAR map. The rig's guesses are the calibration's.
  std::optional<CalibrationResult> check_of;
  // Where fixed sensors of the rig are held (WithAddedSensors): their lenses and readouts do not move either,
  // and its sigmas become part of the result's.
  std::optional<CalibrationResult> held_from;
  // Sensors that the rig has lost already: what they recorded cannot be used.
  std::vector<RejectedSensor> unusable;
};

}  // namespace mlic
