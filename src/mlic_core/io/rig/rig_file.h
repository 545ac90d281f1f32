#pragma once

#include <filesystem>

#include "mlic_core/sensors/rig.h"

namespace mlic {

// Reads a rig file (docs/conventions.md gives the keys). Sensors with `enabled: false` are checked and left
// out. Throws InputError, one line with file, line and key, for an unknown or doubled key, a wrong type, a
// value out of range, a missing topic, two sensors with the same name, topic or frame, a camera with neither
// intrinsics nor field of view, no enabled sensor at all, or values left at `???` (all of them in one line).
Rig LoadRigFile(const std::filesystem::path& path);

// Writes a rig so that LoadRigFile reads it back: guesses to 1e-9 m and 1e-9 rad. A camera with neither
// intrinsics nor field of view gets `fov_deg: ???`, which LoadRigFile refuses.
void WriteRigFile(const std::filesystem::path& path, const Rig& rig);

}  // namespace mlic
