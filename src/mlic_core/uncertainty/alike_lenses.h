#pragma once

#include <Eigen/Core>

#include "mlic_core/sensors/camera_intrinsics.h"

namespace mlic {

// By how much single terms of a rational lens may be off although it projects right: numerator and
// denominator may be multiplied by nearly the same polynomial, and along such ways no derivative shows how
// far they go, as they bend. The first term of the denominator is moved to and fro, the other radial ones
// follow by least squares, as far as projections within `radius` (px from the centre) differ by kPatternError
// (rms), which no observation shows, and the denominator stays positive there; at most by 1. One standard
// deviation of each parameter in the model's order, zero of those that are not radial terms and of other
// models.
Eigen::VectorXd SpreadOfAlikeLenses(const CameraIntrinsics& lens, double radius);

}  // namespace mlic
