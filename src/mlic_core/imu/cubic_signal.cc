#include "mlic_core/imu/cubic_signal.h"

namespace mlic {

CubicSignal::CubicSignal(const std::vector<double>& times, std::vector<Eigen::Vector3d> values,
                         double longest_bridged)
    : values_(std::move(values)) {
  const std::size_t n = values_.size();
  lengths_.resize(n - 1);
  for (std::size_t i = 0; i + 1 < n; ++i) lengths_[i] = times[i + 1] - times[i];
  const auto slope = [&](std::size_t i) -> Eigen::Vector3d {
    return (values_[i + 1] - values_[i]) / lengths_[i];
  };
  const auto usable = [&](std::size_t i) { return i < n - 1 && lengths_[i] <= longest_bridged; };

  derivatives_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const bool before = i > 0 && usable(i - 1);
    const bool after = usable(i);
    if (before && after) {
      const double total = lengths_[i - 1] + lengths_[i];
      derivatives_[i] = (lengths_[i] * slope(i - 1) + lengths_[i - 1] * slope(i)) / total;
    } else if (after) {
      derivatives_[i] = slope(i);
      if (usable(i + 1))
        derivatives_[i] += (slope(i) - slope(i + 1)) * lengths_[i] / (lengths_[i] + lengths_[i + 1]);
    } else if (before) {
      derivatives_[i] = slope(i - 1);
      if (i > 1 && usable(i - 2)) {
        derivatives_[i] +=
            (slope(i - 1) - slope(i - 2)) * lengths_[i - 1] / (lengths_[i - 1] + lengths_[i - 2]);
      }
    } else {
      derivatives_[i].setZero();
    }
  }
}

Eigen::Vector3d CubicSignal::Value(std::size_t i, double s) const {
  const double h = lengths_[i];
  const double u = s / h;
  const Eigen::Vector3d step = values_[i + 1] - values_[i];
  const Eigen::Vector3d d0 = h * derivatives_[i];
  const Eigen::Vector3d d1 = h * derivatives_[i + 1];
  return values_[i] + u * (d0 + u * (3.0 * step - 2.0 * d0 - d1 + u * (d0 + d1 - 2.0 * step)));
}

}  // namespace mlic
