#pragma once

#include <vector>

#include "mlic_core/initialization/lidar_imu.h"
#include "mlic_core/pipeline/stage_clock.h"

namespace mlic {

// Each LiDAR's odometry in each drive, with its alignment to the gyroscope; an interrupted run takes up what
// it kept.
std::vector<DriveOdometry> OdometryStage(const StageContext& context);

}  // namespace mlic
