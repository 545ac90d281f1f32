#pragma once

#include "mlic_core/result/result.h"
#include "mlic_core/sensors/measurements.h"
#include "mlic_core/uncertainty/adjustment.h"

namespace mlic {

// Reasons and warnings where the IMU contradicts the trajectory: there something is lost, and sigmas say
// nothing.
void JudgeImuAgreement(const Dataset& dataset, const Adjustment& adjustment, CalibrationResult* result);

// Whose axes the IMU's are.
ImuAlignment AlignmentOf(const Adjustment& adjustment);

}  // namespace mlic
