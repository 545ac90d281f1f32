#include "mlic_core/calibration/imu_disagreement.h"

#include <algorithm>
#include <cmath>

namespace mlic {
namespace {

constexpr double kLength = 1.0;  // s: vibration averages out, and a lost trajectory lasts longer
constexpr int kFewestSamples = 5;

struct Stretch {
  Eigen::Matrix<double, 6, 1> sum = Eigen::Matrix<double, 6, 1>::Zero();
  int samples = 0;

  Eigen::Vector3d Mean(bool gyroscope) const {
    return (gyroscope ? sum.head<3>() : sum.tail<3>()) / std::max(1, samples);
  }
  double Ratio(bool gyroscope, const ImuSigma& sigma) const {
    if (samples < kFewestSamples) return 0.0;
    const double of_one = gyroscope ? sigma.gyroscope : sigma.accelerometer;
    return Mean(gyroscope).norm() * std::sqrt(samples / 3.0) / of_one;
  }
};

std::vector<Stretch> Stretches(const Dataset& dataset, const CalibrationState& state, std::size_t drive) {
  const double start = state.drives[drive].trajectory.Start();
  std::vector<Stretch> stretches;
  const ImuResiduals residuals = EvaluateImuResiduals(dataset, state, drive);
  for (std::size_t k = 0; k < residuals.times.size(); ++k) {
    const auto at = static_cast<std::size_t>((residuals.times[k] - start) / kLength);
    if (at >= stretches.size()) stretches.resize(at + 1);
    stretches[at].sum += residuals.values[k];
    ++stretches[at].samples;
  }
  return stretches;
}

}  // namespace

std::optional<ImuDisagreement> FindImuDisagreement(const Dataset& dataset, const CalibrationState& state,
                                                   const std::vector<ImuSigma>& sigmas, double least_ratio) {
  std::optional<ImuDisagreement> worst;
  for (std::size_t d = 0; d < state.drives.size(); ++d) {
    const std::vector<Stretch> stretches = Stretches(dataset, state, d);
    for (const bool gyroscope : {false, true}) {
      for (std::size_t s = 0; s < stretches.size(); ++s) {
        const double ratio = stretches[s].Ratio(gyroscope, sigmas[d]);
        if (ratio < least_ratio || (worst && ratio <= worst->ratio)) continue;
        std::size_t first = s, last = s;
        while (first > 0 && stretches[first - 1].Ratio(gyroscope, sigmas[d]) >= least_ratio) --first;
        while (last + 1 < stretches.size() &&
               stretches[last + 1].Ratio(gyroscope, sigmas[d]) >= least_ratio) {
          ++last;
        }
        worst = {d,    first * kLength, (last + 1) * kLength, gyroscope, stretches[s].Mean(gyroscope).norm(),
                 ratio};
      }
    }
  }
  return worst;
}

}  // namespace mlic
