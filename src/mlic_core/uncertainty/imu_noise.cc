#include "mlic_core/uncertainty/imu_noise.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "mlic_core/common/order_statistics.h"
#include "mlic_core/imu/noise_spectrum.h"
#include "mlic_core/uncertainty/stretch_means.h"

namespace mlic {
namespace {

constexpr std::size_t kFewest = 35;           // samples; from: guard
constexpr std::size_t kFewestOfStretch = 64;  // samples; from: derivation, NoiseSpectrum's least
// s; from: guard, short enough that a knock leaves the rest of the drive as it is, long enough for a
// spectrum.
constexpr double kStretch = 4.0;
constexpr double kChance = 3.0;           // standard deviations; from: derivation, 1 in 700
constexpr double kChanceOfStretch = 4.0;  // the same, of one of many; from: derivation, 1 in thousands
constexpr std::array<double, 4> kLengths{1, 2, 5, 10};  // s; from: definition

double RobustSigma(const Eigen::VectorXd& values) {
  std::vector<double> sizes;
  for (const double value : values) sizes.push_back(std::abs(value));
  return 1.4826 * Median(std::move(sizes));
}

double RateOf(const ImuResiduals& residuals) {
  return (static_cast<double>(residuals.times.size()) - 1.0) /
         std::max(1e-9, residuals.times.back() - residuals.times.front());
}

// How much of a level that is 1 by chance counts: nothing up to the limit, all from twice the limit's
// distance to 1 on. Continuous, or rounds would alternate between the two sides of the limit for ever.
double ShareBeyondChance(double level, double limit) {
  return std::clamp((level - limit) / (limit - 1.0), 0.0, 1.0);
}

// One sensor of an IMU: three components of residuals that follow each other.
struct Sensor {
  int first;    // component
  double rate;  // Hz
  double top;   // Hz, of the band that the spline follows
};

// The median of the levels of so many samples over the band above the spline's has this relative scatter: of
// a median of exponential variates (1 / ln(2)^2), with neighbours that a Hann window ties (35 / 18).
double LevelScatter(const Sensor& sensor, std::size_t samples) {
  const double bins = 3.0 * std::max(1.0, sensor.top * static_cast<double>(samples) / sensor.rate);
  return std::sqrt(35.0 / 18.0 / (std::log(2.0) * std::log(2.0)) / bins);
}

// Sigmas of the samples from `begin` to `end`.
Eigen::Vector3d SigmaOf(const ImuResiduals& residuals, const Sensor& sensor, std::size_t begin,
                        std::size_t end) {
  const auto count = static_cast<Eigen::Index>(end - begin);
  Eigen::Vector3d sigma;
  double colour =
      0.0;  // mean over the axes of the density by that of white noise with the residuals' scatter
  for (int a = 0; a < 3; ++a) {
    Eigen::VectorXd values(count);
    for (Eigen::Index k = 0; k < count; ++k) values[k] = residuals.values[begin + k][sensor.first + a];
    sigma[a] = std::max(1e-12, RobustSigma(values));
    colour += NoiseSpectrum(values, sensor.rate).WhiteVariance(sensor.top, 2.0 * sensor.top) /
              (3.0 * sigma[a] * sigma[a]);
  }
  const double share = ShareBeyondChance(colour, 1.0 + kChance * LevelScatter(sensor, end - begin));
  return sigma * std::sqrt(1.0 + share * (colour - 1.0));
}

// Sigmas of the drive's usual stretches, by axis, and by what those of each stretch exceed them.
struct SensorCourse {
  Eigen::Vector3d usual;
  std::vector<double> growth;  // empty: of none
};

SensorCourse CourseOf(const ImuResiduals& residuals, const Sensor& sensor, std::size_t stretch,
                      const Eigen::Vector3d& given) {
  const std::size_t count = residuals.values.size();
  SensorCourse course{given.cwiseMax(SigmaOf(residuals, sensor, 0, count)), {}};
  const std::size_t stretches = count / stretch;
  if (stretch < kFewestOfStretch || stretches < 2) return course;
  std::vector<Eigen::Vector3d> sigmas;
  std::vector<double> levels;
  for (std::size_t s = 0; s < stretches; ++s) {
    sigmas.push_back(SigmaOf(residuals, sensor, s * stretch, s + 1 < stretches ? (s + 1) * stretch : count));
    levels.push_back(sigmas.back().cwiseQuotient(course.usual).squaredNorm() / 3.0);
  }
  const double limit = 1.0 + kChanceOfStretch * LevelScatter(sensor, stretch), median = Median(levels);
  std::array<std::vector<double>, 3> of_usual;
  for (std::size_t s = 0; s < stretches; ++s) {
    if (levels[s] > limit * median) continue;
    for (int a = 0; a < 3; ++a) of_usual[a].push_back(sigmas[s][a]);
  }
  if (of_usual[0].size() == stretches) return course;
  for (int a = 0; a < 3; ++a) course.usual[a] = std::max(given[a], Median(of_usual[a]));
  for (std::size_t s = 0; s < stretches; ++s) {
    const double level = sigmas[s].cwiseQuotient(course.usual).squaredNorm() / 3.0;
    const double share = ShareBeyondChance(levels[s] / median, limit);
    course.growth.push_back(std::sqrt(1.0 + share * std::max(0.0, level - 1.0)));
  }
  return course;
}

}  // namespace

ImuSigmaCourse MeasureImuSigma(const ImuResiduals& residuals, const SplitSpline& trajectory,
                               const ImuSigma& given) {
  if (residuals.values.size() < kFewest) return {given};
  const double rate = RateOf(residuals);
  const Sensor gyroscope{0, rate, TopOfBand(rate, trajectory.rotation.knots().spacing)};
  const Sensor accelerometer{3, rate, TopOfBand(rate, trajectory.position.knots().spacing)};
  const auto stretch = static_cast<std::size_t>(kStretch * rate);
  const SensorCourse of_rates = CourseOf(residuals, gyroscope, stretch, given.gyroscope);
  const SensorCourse of_force = CourseOf(residuals, accelerometer, stretch, given.accelerometer);
  ImuSigmaCourse course{{of_rates.usual, of_force.usual}, residuals.times.front(), kStretch, {}};
  for (std::size_t s = 0; s < std::max(of_rates.growth.size(), of_force.growth.size()); ++s) {
    course.growth.push_back({of_rates.growth.empty() ? 1.0 : of_rates.growth[s],
                             of_force.growth.empty() ? 1.0 : of_force.growth[s]});
  }
  return course;
}

ImuMeanExcess MeasureMeanExcess(const ImuResiduals& residuals, const ImuSigmaCourse& sigma) {
  ImuMeanExcess excess;
  if (residuals.times.empty()) return excess;
  const double duration = residuals.times.back() - residuals.times.front();
  for (const double length : kLengths) {
    if (duration < 2.0 * length) break;
    const StretchMeans means(residuals, sigma, length);
    for (int sensor = 0; sensor < 2; ++sensor) {
      const double found = means.Excess(3 * sensor);
      if (found <= excess.variance[sensor]) continue;
      excess.variance[sensor] = found;
      excess.seconds[sensor] = length;
    }
  }
  return excess;
}

}  // namespace mlic
