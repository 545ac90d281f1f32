#pragma once

#include <functional>
#include <string>
#include <vector>

#include "mlic_core/common/progress.h"
#include "mlic_core/inspection/cost.h"
#include "mlic_core/sensors/rig.h"
#include "mlic_ros/bag/bag_set.h"

namespace mlic {

// By the numbers of messages in the bags. All topics of the rig are in them, by these names.
SensorLoad LoadOf(const BagSet& bags, const Rig& rig);

// Of all together, s.
double LengthOf(const std::vector<BagSet::Interval>& drives);

// Of drives that together are longer than `longest` seconds, parts of the longest of them, as many seconds of
// each, whose motion shows the calibration best (inspection/telling_stretch.h). For that the IMU is read
// once. progress: the done share. notes: a line for each drive of which a part is taken. Throws InputError
// for a damaged bag, Cancelled when the token is set.
std::vector<BagSet::Interval> ChooseParts(const BagSet& bags, const Rig& rig,
                                          std::vector<BagSet::Interval> drives, double longest,
                                          const CancellationToken& cancellation,
                                          const std::function<void(double)>& progress,
                                          std::vector<std::string>* notes);

}  // namespace mlic
