#pragma once

#include <string>
#include <vector>

#include "mlic_core/result/result.h"
#include "mlic_core/sensors/measurements.h"
#include "mlic_core/sensors/rig.h"
#include "mlic_core/uncertainty/adjustment.h"

namespace mlic {

// The checks that the verdict rests on (docs/method.md, section 12): reasons and warnings of the result are
// the failures among them. analysis, residuals: of the adjustment. taking_part: of each sensor in the
// SensorOrder; others have a reason of their own.
std::vector<QualityCheck> MakeChecks(const Rig& rig, const Dataset& dataset, const Adjustment& adjustment,
                                     const ObservabilityAnalysis& analysis,
                                     const std::vector<bool>& taking_part,
                                     const std::vector<ResidualSummary>& residuals);

// One line for people: the check, its value and limit.
std::string DescribeCheck(const QualityCheck& check);

}  // namespace mlic
