#pragma once

#include <Eigen/Core>
#include <vector>

#include "mlic_core/solver/accumulator.h"
#include "mlic_core/solver/envelope_cholesky.h"

namespace mlic {

// Takes out of the normal equations what the landmarks' own parameters explain: minus the sum over landmarks
// of W own^-1 W^T, where W holds a landmark's couplings. docs/method.md, section 6.

// A: the control points with the border of calibration and gradient (last row); corner: of the border itself,
// lower triangle.
void EliminateLandmarks(const std::vector<LandmarkCoupling>& landmarks, EnvelopeMatrix* A,
                        Eigen::MatrixXd* corner);

// The same while the control points are held.
void EliminateLandmarksFromCorner(const std::vector<LandmarkCoupling>& landmarks, Eigen::MatrixXd* corner);

}  // namespace mlic
