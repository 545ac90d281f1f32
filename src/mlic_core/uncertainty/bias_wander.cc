#include "mlic_core/uncertainty/bias_wander.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "mlic_core/uncertainty/stretch_means.h"

namespace mlic {
namespace {

// Of the course, s. A bias that settles with a time constant of a minute is within half a hundredth of what
// it wanders by of lines so long (spacing^2 / 8 times its curvature); what the shortest have of noise, the
// prior keeps small. from: derivation
constexpr double kLongest = 10.0, kShortest = 2.5;
constexpr double kFewest = 4.0;     // intervals; from: guard, fewer do not tell wandering from a mean
constexpr double kMost = 20.0;      // intervals; from: guard, unknowns
constexpr double kRounding = 1e-9;  // of an interval; from: guard
constexpr double kLeastStep = 0.1;  // of a mean's noise; from: guard, keeps the equations regular

// Of one sensor: its components from `first` on.
double Step(const StretchMeans& means, int first) {
  double squares = 0.0;
  for (std::size_t s = 1; s < means.Count(); ++s) {
    squares += (means.Of(s) - means.Of(s - 1)).segment<3>(first).squaredNorm();
  }
  const double of_noise = means.Noise().segment<3>(first).sum() / 3.0;
  const double variance = squares / (3.0 * (static_cast<double>(means.Count()) - 1.0)) - 2.0 * of_noise;
  return std::sqrt(std::max(variance, kLeastStep * kLeastStep * of_noise));
}

}  // namespace

std::optional<BiasWander> FindBiasWander(const ImuResiduals& residuals, const ImuSigmaCourse& sigma) {
  if (residuals.times.empty()) return std::nullopt;
  BiasWander wander;
  wander.start = residuals.times.front();
  const double duration = residuals.times.back() - wander.start;
  const double longest = std::clamp(duration / kFewest, kShortest, std::max(kLongest, duration / kMost));
  if (duration < kFewest * kShortest) return std::nullopt;
  wander.intervals = static_cast<std::size_t>(std::ceil(duration / longest - kRounding));
  wander.spacing = duration / static_cast<double>(wander.intervals);
  const StretchMeans means(residuals, sigma, wander.spacing);
  if (means.Excess(0) <= 1.0 && means.Excess(3) <= 1.0) return std::nullopt;
  wander.steps = {Step(means, 0), Step(means, 3)};
  return wander;
}

}  // namespace mlic
