#pragma once

#include <vector>

#include "mlic_core/common/time_interval.h"
#include "mlic_core/inspection/pose_information.h"
#include "mlic_core/sensors/measurements.h"
#include "mlic_core/sensors/rig.h"

namespace mlic {

// The stretch of `duration` seconds whose motion shows a sensor's rotation, lever arm and time offset best:
// the least product of their sigmas in the forecast (inspection/forecast.h), guesses included, of stretches a
// quarter of their duration apart. All of the samples where they span no more; the first where nothing is
// shown anywhere. samples: at least two, in order of time; imu, poses: as for the forecast.
TimeInterval MostTellingStretch(const std::vector<ImuSample>& samples, const ImuConfig& imu,
                                const PoseNoise& poses, double duration);

}  // namespace mlic
