#pragma once

#include <string>
#include <vector>

#include "mlic_core/common/progress.h"
#include "mlic_core/common/time_interval.h"
#include "mlic_core/result/result.h"
#include "mlic_core/sensors/measurements.h"
#include "mlic_core/uncertainty/adjustment.h"
#include "mlic_core/uncertainty/halves_statistics.h"

namespace mlic {

// Where the recording is cut in two: the stretches of each drive in either. The first has this share of what
// the rig turns (the integral of the squared angular rate): it is turning that shows a sensor's pose and
// clock to the IMU, and a vehicle that is parked for half of a drive would leave a half by the clock with
// nothing.
struct Halves {
  std::vector<TimeInterval> first, second;
};
Halves CutByTurning(const CalibrationState& state, double share);

// The calibration of parts of the drive alone, from the found state on and with its association: planes and
// points are estimated anew from the part's observations, and so are trajectory, biases and all that the
// calibration's solve leaves free. Compared are the halves, and either half with the quarter at the other
// end: a half in which a sensor came loose late, or early, sides with its larger piece. Returns for each
// LiDAR, then each camera by how much the parts that differ most do, against what their covariances allow;
// these grow as the whole's, by what observations share within the parts. What priors and guesses say is the
// same in both: its error is common, and no agreement. Empty where a half's equations have no solution.
// docs/method.md, section 12.
std::vector<SensorHalves> CompareHalves(const Adjustment& adjustment, const Dataset& dataset,
                                        const CancellationToken& cancellation);

// For people: each quantity's difference, in units of its own and in sigmas.
std::string Describe(const SensorHalves& sensor);

}  // namespace mlic
