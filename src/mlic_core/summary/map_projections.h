#pragma once

#include <cstddef>
#include <optional>

#include "mlic_core/result/result.h"
#include "mlic_core/sensors/measurements.h"
#include "mlic_core/sensors/rig.h"
#include "mlic_core/uncertainty/adjustment.h"

namespace mlic {

// Of a camera one photo of the first drive with what the LiDARs saw about that time, without those that were
// rejected: projected by the camera before photos were matched (cameras_before; none: as the state has it),
// as the state has it, and with the poses that the rig file guesses. The photo is the one with most places of
// the map; without any, that of the middle of the drive. Of a camera that was not found only the guess is
// drawn. Nothing: no LiDARs, or neither found nor guessed.
std::optional<CameraProjection> ProjectOnPhoto(const Rig& rig, const Dataset& dataset,
                                               const Adjustment& adjustment, std::size_t camera);

}  // namespace mlic
