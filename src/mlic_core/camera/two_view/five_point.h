#pragma once

#include <Eigen/Core>

namespace mlic {

constexpr int kMostEssentialMatrices = 10;  // from: paper, Nister 2004

// The essential matrices E with b_i . (E a_i) = 0 for five pairs of bearings, of Frobenius norm sqrt(2).
// Returns how many (0 to 10) were written to `solutions`. The ten cubic constraints on the null space of the
// five linear ones, solved by the eigenvectors of a 10 x 10 matrix: Stewenius, Engels, Nister, "Recent
// developments on direct relative orientation", 2006. See two_view.h for how it does beside OpenGV's.
int SolveFivePoint(const Eigen::Vector3d (&bearings_a)[5], const Eigen::Vector3d (&bearings_b)[5],
                   Eigen::Matrix3d (&solutions)[kMostEssentialMatrices]);

}  // namespace mlic
