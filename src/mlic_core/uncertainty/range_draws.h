#pragma once

#include <Eigen/Core>
#include <vector>

#include "mlic_core/uncertainty/range_errors.h"

namespace mlic {

// Mean square of what all LiDARs' ranges err by (RangeErrors::Of, squared), given what is found of it with
// this covariance: parameters of which `drawn` has true (of each LiDAR) are draws from normal distributions
// of mean zero, each kind of a size of its own, in the mean over all sizes up to `largest` (m, and m for each
// power of ten); nothing else is known of the others.
Eigen::MatrixXd MeanSquareOfRangeErrors(const RangeErrors& found, const std::vector<FreeRanges>& drawn,
                                        const Eigen::MatrixXd& covariance, double largest);

}  // namespace mlic
