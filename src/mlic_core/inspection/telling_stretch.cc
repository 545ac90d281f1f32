#include "mlic_core/inspection/telling_stretch.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mlic_core/common/parallel.h"
#include "mlic_core/inspection/forecast.h"

namespace mlic {
namespace {

// The logarithm of the product of all sigmas; infinite where there is no forecast.
double LogOfSigmas(const std::vector<ImuSample>& samples, const ImuConfig& imu, const PoseNoise& poses) {
  const auto forecast = ForecastObservability(samples, imu, poses);
  if (!forecast) return std::numeric_limits<double>::infinity();
  return forecast->rotation_sigma.array().log().sum() + forecast->translation_sigma.array().log().sum() +
         std::log(forecast->time_offset_sigma);
}

}  // namespace

TimeInterval MostTellingStretch(const std::vector<ImuSample>& samples, const ImuConfig& imu,
                                const PoseNoise& poses, double duration) {
  const double begin = samples.front().time, end = samples.back().time;
  if (end - begin <= duration) return {begin, end};
  const auto steps = static_cast<std::size_t>(std::ceil(4.0 * (end - begin - duration) / duration));
  const double step = (end - begin - duration) / static_cast<double>(steps);
  std::vector<double> scores(steps + 1);
  ParallelFor(scores.size(), [&](std::size_t i) {
    const auto at = [&](double time) {
      return std::lower_bound(samples.begin(), samples.end(), time,
                              [](const ImuSample& sample, double t) { return sample.time < t; });
    };
    const double from = begin + step * static_cast<double>(i);
    scores[i] = LogOfSigmas({at(from), at(from + duration)}, imu, poses);
  });
  const auto best = std::min_element(scores.begin(), scores.end()) - scores.begin();
  const double from = begin + step * static_cast<double>(best);
  return {from, from + duration};
}

}  // namespace mlic
