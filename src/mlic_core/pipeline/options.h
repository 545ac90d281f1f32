#pragma once

#include <filesystem>
#include <memory>

#include "mlic_core/camera/features/feature_matcher.h"

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
};

}  // namespace mlic
