#pragma once

#include "mlic_core/initialization/drive_odometry.h"
#include "mlic_core/pipeline/adjustment_steps.h"
#include "mlic_core/pipeline/stage_clock.h"

namespace mlic {

// Whether cameras are placed without the IMU too. A check looks for its sensors where they were: it says of
// cameras what the IMU shows of them.
bool WithCameras(const StageContext& context);

// What the LiDARs' maps show of each other and of cameras where the whole is refused: without the IMU.
// whole: the refused calibration; null: it has not come that far.
void PairStage(const StageContext& context, const DriveOdometry& odometry, const Adjustment* whole);

}  // namespace mlic
