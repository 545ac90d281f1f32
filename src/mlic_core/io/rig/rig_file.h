#pragma once

#include <filesystem>

#include "mlic_core/sensors/rig.h"

namespace mlic {

// Reads a rig file (docs/conventions.md gives the keys). Sensors with `enabled: false` are checked and left
// out. Throws InputError, one line with file, line and key, for an unknown or doubled key, a wrong type, a
// value out of range, a missing topic, two sensors with the same name, topic or frame, or no enabled sensor
// at all.
Rig LoadRigFile(const std::filesystem::path& path);

// Writes a rig so that LoadRigFile reads it back: guesses to 1e-9 m and 1e-9 rad.
void WriteRigFile(const std::filesystem::path& path, const Rig& rig);

}  // namespace mlic
