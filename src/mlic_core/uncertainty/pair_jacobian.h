#pragma once

#include <Eigen/Core>

#include "mlic_core/sensors/rig.h"

namespace mlic {

// By which the relative pose T_a_b and the difference of the offsets (rotation and translation along the axes
// of a, as PoseSigma has them) follow both sensors' (a, b).
Eigen::Matrix<double, 7, 14> PairJacobian(const SensorCalibration& a, const SensorCalibration& b);

}  // namespace mlic
