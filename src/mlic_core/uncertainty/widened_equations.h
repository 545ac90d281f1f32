#pragma once

#include <Eigen/Core>
#include <vector>

#include "mlic_core/solver/accumulator.h"

namespace mlic {

// For parameters that are not part of every solve and are looked at beside one: they follow the calibration's
// in the corner of the normal equations, and all else follows them.

// Makes room for so many.
void Widen(Eigen::Index more, Accumulator* sum, std::vector<LandmarkCoupling>* couplings);

// The inverse's rows and columns [begin, begin + count), those zero that are not free. information: of all,
// with what priors say.
Eigen::MatrixXd PartOfCovariance(Eigen::MatrixXd information, const std::vector<bool>& free,
                                 Eigen::Index begin, Eigen::Index count);

}  // namespace mlic
