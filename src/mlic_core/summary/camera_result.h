#pragma once

#include "mlic_core/result/result.h"
#include "mlic_core/uncertainty/adjustment.h"

namespace mlic {

// Makes the result that of a camera: its lens and shutter, with their sigmas.
void AddIntrinsics(const CameraCalibration& camera, const ObservabilityAnalysis::Intrinsics& analysis,
                   SensorResult* result);

// Widens the sigmas of single terms of the lens where other terms make up for them. camera: index in the rig.
void AddAlikeLenses(const Adjustment& adjustment, std::size_t camera, SensorResult* result);

}  // namespace mlic
