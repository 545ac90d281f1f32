#pragma once

#include <string>
#include <vector>

#include "mlic_core/result/result.h"
#include "mlic_core/uncertainty/adjustment.h"

namespace mlic {

// Checks of one camera alone (docs/method.md, section 12): where it sees landmarks, how well they project,
// what the LiDAR map says of it, how far its lens model holds. camera: index in the rig; residuals: of the
// adjustment.
std::vector<QualityCheck> MakeCameraChecks(const std::string& name, std::size_t camera,
                                           const Adjustment& adjustment,
                                           const std::vector<ResidualSummary>& residuals);

}  // namespace mlic
