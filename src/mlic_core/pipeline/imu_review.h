#pragma once

#include "mlic_core/pipeline/adjustment_steps.h"

namespace mlic {

// The noise of the IMU that the last solve's residuals show.
void MeasureImuSigmas(const Dataset& dataset, Adjustment* adjustment);

// Decides about which axes the accelerometer's rotation to the gyroscope is shown, and whose the IMU's axes
// are (ReviewAlignment). True if they are others than in this round.
bool ReviewAxes(const AdjustmentContext& context, Adjustment* adjustment);

// Decides whether scale and shear of the IMU are estimated (docs/method.md, section 10). A first look, with
// sigmas that are too small, leaves most drives as they are. True if they are from now on; then the state has
// been solved for anew.
bool ReviewMatrices(const AdjustmentContext& context, Adjustment* adjustment);

// Decides whether the IMU's biases wander (docs/method.md, section 10), once. True if they are estimated as a
// course from now on; then the state has been solved for anew.
bool ReviewBiases(const AdjustmentContext& context, Adjustment* adjustment);

// Adds to the doubt of the points what biases that are estimated as constants may wander by all the same.
void DoubtConstantBiases(const AdjustmentContext& context, Adjustment* adjustment);

// What the IMU's slow errors, which single samples do not show, take from its say: to be measured once, as
// with less say it contradicts the trajectory more. Solves once more where they take any.
void WeakenImuBySlowErrors(const AdjustmentContext& context, Adjustment* adjustment);

}  // namespace mlic
