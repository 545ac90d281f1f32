#include "mlic_core/uncertainty/halves_statistics.h"

#include <algorithm>
#include <cmath>

#include "mlic_core/common/significance.h"

namespace mlic {
namespace {

constexpr std::size_t kComparisons = 3;  // DriveParts; from: structural
// Degrees of freedom with which our sigmas are known: to a sixth. from: measured, lidar open 1 to 16, the
// mean squares of errors over sigmas of the kinds of parameters are 0.76 to 1.63 (docs/benchmark.md)
constexpr int kFreedom = 20;

}  // namespace

double LargestByChance(const std::vector<SensorHalves>& sensors) {
  constexpr double kFalseAlarms = 3e-3;  // from: definition, with which three sigmas are exceeded
  std::size_t comparisons = 0;
  for (const SensorHalves& sensor : sensors) {
    for (const HalvesDifference& difference : sensor.quantities) {
      const auto& sigma = difference.sigma;
      const auto shown = std::count_if(sigma.begin(), sigma.end(), [](double s) { return s > 0.0; });
      comparisons += kComparisons * (1 + (sigma.size() > 1 ? static_cast<std::size_t>(shown) : 0));
    }
  }
  return StudentDeviation(kFalseAlarms / static_cast<double>(std::max<std::size_t>(1, comparisons)),
                          kFreedom);
}

double GrowthOfSigmas(const HalvesDifference& difference) {
  return std::sqrt(std::max(1.0, (kFreedom + difference.squares) / (kFreedom + difference.directions)));
}

double WorstOf(const SensorHalves& sensor) {
  double worst = 0.0;
  for (const HalvesDifference& difference : sensor.quantities) {
    worst = std::max(worst, difference.Worst());
  }
  return worst;
}

}  // namespace mlic
