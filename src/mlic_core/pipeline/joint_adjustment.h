#pragma once

#include <functional>

#include "mlic_core/pipeline/adjustment_steps.h"

namespace mlic {

struct JointOptions {
  // Landmarks other than kNone need the adjustment's cameras (AddCameras), the map LiDARs as well.
  Landmarks landmarks = Landmarks::kNone;
  // from: definition, docs/method.md section 8.
  double until = 0.1;  // what of its sigma the calibration may still move by in the last round
  // Whether rings and ranges that err and clocks that drift are found and corrected. A parked LiDAR's rings
  // see the same places all the time, and err there as the places do; its clock shows nothing.
  bool find_sensor_errors = true;
  bool find_imu_axes = true;  // the accelerometer's rotation to the gyroscope, where it is shown
  // Called between two rounds: a run that goes on from there gives the same bits.
  std::function<void(const Adjustment&)> after_round = [](const Adjustment&) {};
};

// For people: how the adjustment with these landmarks is called.
const char* NameOf(Landmarks landmarks);

// So many rounds these may be in all, of what has happened in them: more after moves, and more still where
// the map goes on to grow, as a trajectory among trees is drawn straight little by little.
int MostRounds(const JointRounds& rounds);

// docs/method.md, section 8: one map of all LiDARs and all landmarks, everything moves. Association and solve
// in turn until the calibration is settled. Goes on with the rounds of an adjustment whose rounds had the
// same landmarks, else counts them anew.
Adjustment AdjustJointly(Adjustment adjustment, const AdjustmentContext& context,
                         const JointOptions& options);

// Once the calibration is settled. What the motion does not show of translations is put to the guesses, and
// the rest solved for once more (uncertainty/held_translations.h). Then how well the map fits the photos
// where no solve looked, of the adjustment with the map; and by what the information is too good. Sigmas grow
// by the latter.
void MeasureUncertainty(const AdjustmentContext& context, Adjustment* adjustment);

}  // namespace mlic
