#pragma once

#include <vector>

#include "mlic_core/result/result.h"
#include "mlic_core/sensors/measurements.h"
#include "mlic_core/uncertainty/adjustment.h"
#include "mlic_core/uncertainty/imu_consistency.h"

namespace mlic {

// Of the mean of the IMU's residuals over a second, in the noise of such a mean: more contradicts the
// trajectory. from: definition, white noise gives at most 3 in an hour; trajectories that were lost gave 17
// and 35.
constexpr double kImuContradicts = 12.0;

// By how much means of the IMU's residuals over 1 to 10 s may exceed what its noise allows: sigmas widen up
// to there, beyond it they say nothing. from: definition
constexpr double kImuSlowErrors = 3.0;

// The largest such factor of gyroscope and accelerometer over the drives.
double LargestSlowError(const Adjustment& adjustment);

// The worst second of the IMU over the drives, in the noise of its mean; from least on.
std::vector<ImuDisagreement> DisagreementsOfImu(const Dataset& dataset, const Adjustment& adjustment,
                                                double least);

// Reasons and warnings where the IMU contradicts the trajectory: there something is lost, and sigmas say
// nothing.
void JudgeImuAgreement(const Dataset& dataset, const Adjustment& adjustment, CalibrationResult* result);

// Whether what was found of the IMU itself, its biases and the lag of its accelerometer, is what IMUs have:
// in a wrong minimum it takes what the trajectory does not explain.
QualityCheck CheckImuState(const Adjustment& adjustment);

// Whose axes the IMU's are.
ImuAlignment AlignmentOf(const Adjustment& adjustment);

}  // namespace mlic
