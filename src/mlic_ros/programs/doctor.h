#pragma once

#include "mlic_core/common/progress.h"
#include "mlic_core/inspection/finding.h"
#include "mlic_core/sensors/rig.h"
#include "mlic_ros/bag/bag_set.h"

namespace mlic {

// Looks at the sensors of a rig in each drive of the bags before anything is calibrated, prints what it
// finds (docs/inspection.md), and returns it. Throws InputError for a damaged bag, Cancelled when the token
// is set.
Findings Diagnose(const BagSet& bags, const Rig& rig, const CancellationToken& cancellation);

}  // namespace mlic
