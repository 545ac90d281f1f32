#pragma once

#include <optional>

#include "mlic_core/sensors/stamp_course.h"
#include "mlic_core/uncertainty/stamp_errors.h"

namespace mlic {

// The course that the scans' (or images') own time errors follow, docs/method.md, section 8.1: a random walk
// seen through their noise, its variance by maximum likelihood, smoothed forwards and backwards (Rauch, Tung,
// Striebel, 1965); less its mean and slope, which are offset and drift. None where the data speak for it by
// less than three sigmas. known: the stamps wander, and this is what is left of it; then none only where the
// data speak against it.
std::optional<StampCourse> FindStampCourse(const ScanSums& scans, bool known);

}  // namespace mlic
