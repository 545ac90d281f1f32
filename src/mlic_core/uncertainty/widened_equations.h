#pragma once

#include <Eigen/Core>
#include <vector>

#include "mlic_core/solver/accumulator.h"

namespace mlic {

// For parameters that are not part of every solve and are looked at beside one: they follow the calibration's
// in the corner of the normal equations, and all else follows them.

// Makes room for so many.
void Widen(Eigen::Index more, Accumulator* sum, std::vector<LandmarkCoupling>* couplings);

// Makes those that are not free stand still: identity in their rows and columns.
void HoldFixed(const std::vector<bool>& free, Eigen::MatrixXd* information);

}  // namespace mlic
