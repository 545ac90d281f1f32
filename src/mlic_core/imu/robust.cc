#include "mlic_core/imu/robust.h"

#include <algorithm>

namespace mlic {

double Median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double SigmaFromNorms(const std::vector<double>& norms) {
  constexpr double kMedianOfNorm =
      1.5381722544550522;  // sqrt of the median of chi-squared with 3 degrees of freedom
  return Median(norms) / kMedianOfNorm;
}

double AbsoluteWeight(double norm, double sigma) { return norm <= sigma ? 1.0 : sigma / norm; }

double TukeyWeight(double norm, double sigma) {
  const double ratio = norm / (6.0 * sigma);
  if (ratio >= 1.0) return 0.0;
  return (1.0 - ratio * ratio) * (1.0 - ratio * ratio);
}

}  // namespace mlic
