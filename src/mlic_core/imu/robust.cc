#include "mlic_core/imu/robust.h"

#include "mlic_core/common/order_statistics.h"

namespace mlic {

double SigmaFromNorms(const std::vector<double>& norms) {
  constexpr double kMedianOfNorm =
      1.5381722544550522;  // sqrt of the median of chi-squared with 3 degrees of freedom; from: derivation
  return Median(norms) / kMedianOfNorm;
}

double AbsoluteWeight(double norm, double sigma) { return norm <= sigma ? 1.0 : sigma / norm; }

double TukeyWeight(double norm, double sigma) {
  const double ratio = norm / (6.0 * sigma);
  if (ratio >= 1.0) return 0.0;
  return (1.0 - ratio * ratio) * (1.0 - ratio * ratio);
}

}  // namespace mlic
