#pragma once

#include <string>

#include "mlic_core/result/result.h"

namespace mlic {

// What the sigmas make of points at some distance: pixels of the cameras, centimetres of the LiDARs with a
// figure of the horizon's sectors. Empty where no sensor and no pair has it.
std::string InUseSection(const CalibrationResult& result);

}  // namespace mlic
