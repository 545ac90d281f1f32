#pragma once

#include <string>

#include "mlic_core/result/result.h"

namespace mlic {

// How well every two sensors are known to each other, as a matrix: the largest sigma of rotation and of
// translation, coloured by their shares of what counts as unobservable, which is marked. The poses are folded
// below. Of a result that has pairs.
std::string PairMatrix(const CalibrationResult& result);

}  // namespace mlic
