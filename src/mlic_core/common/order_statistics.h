#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace mlic {

// The value that a share of the sorted values stays below; zero for no values.
template <typename T>
T Quantile(std::vector<T> values, double share) {
  if (values.empty()) return T();
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

// Zero for no values. Of an even number of values the upper of the middle ones.
template <typename T>
T Median(std::vector<T> values) {
  if (values.empty()) return T();
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Between successive items' `time`, in order; zero for fewer than two.
template <typename Timed>
double MedianPeriod(const std::vector<Timed>& ordered) {
  std::vector<double> periods;
  for (std::size_t i = 1; i < ordered.size(); ++i) periods.push_back(ordered[i].time - ordered[i - 1].time);
  return Median(std::move(periods));
}

}  // namespace mlic
