#pragma once

#include <vector>

namespace mlic {

// The sigma of one component of isotropic normal 3-vectors, from the median of their norms (a third of the
// vectors may be anything).
double SigmaFromNorms(const std::vector<double>& norms);

// Weights for iteratively re-weighted least squares of a residual with this norm. The convex one first (L1
// beyond one sigma), then the redescending one (Tukey's biweight, zero beyond 6 sigma), which leaves no trace
// of outliers.
double AbsoluteWeight(double norm, double sigma);
double TukeyWeight(double norm, double sigma);

}  // namespace mlic
