#include "mlic_core/uncertainty/imu_consistency.h"

#include <algorithm>
#include <cmath>

#include "mlic_core/common/order_statistics.h"
#include "mlic_core/problem/imu_terms.h"

namespace mlic {
namespace {

// from: definition, docs/method.md section 12.
constexpr double kLength = 1.0;     // s: vibration averages out, and a lost trajectory lasts longer
constexpr int kFewestSamples = 5;   // from: guard
constexpr double kStandsOut = 4.0;  // times the median second; from: definition, docs/method.md section 12

struct Stretch {
  Eigen::Matrix<double, 6, 1> sum = Eigen::Matrix<double, 6, 1>::Zero();
  Eigen::Matrix<double, 6, 1> variance = Eigen::Matrix<double, 6, 1>::Zero();  // of the sum, by the sigmas
  int samples = 0;

  Eigen::Vector3d Mean(bool gyroscope) const {
    return (gyroscope ? sum.head<3>() : sum.tail<3>()) / std::max(1, samples);
  }
  double Ratio(bool gyroscope) const {
    if (samples < kFewestSamples) return 0.0;
    const Eigen::Matrix<double, 6, 1> squares = sum.cwiseAbs2().cwiseQuotient(variance);
    return std::sqrt((gyroscope ? squares.head<3>() : squares.tail<3>()).sum() / 3.0);
  }
};

std::vector<Stretch> Stretches(const Dataset& dataset, const CalibrationState& state,
                               const ImuSigmaCourse& sigma, std::size_t drive) {
  const double start = state.drives[drive].trajectory.Start();
  std::vector<Stretch> stretches;
  const ImuResiduals residuals = EvaluateImuResiduals(dataset, state, drive);
  for (std::size_t k = 0; k < residuals.times.size(); ++k) {
    const auto at = static_cast<std::size_t>((residuals.times[k] - start) / kLength);
    if (at >= stretches.size()) stretches.resize(at + 1);
    const ImuSigma of_sample = sigma.At(residuals.times[k]);
    stretches[at].sum += residuals.values[k];
    stretches[at].variance.head<3>() += of_sample.gyroscope.cwiseAbs2();
    stretches[at].variance.tail<3>() += of_sample.accelerometer.cwiseAbs2();
    ++stretches[at].samples;
  }
  return stretches;
}

}  // namespace

std::vector<ImuDisagreement> FindImuDisagreements(const Dataset& dataset, const CalibrationState& state,
                                                  const std::vector<ImuSigmaCourse>& sigmas,
                                                  double least_ratio) {
  std::vector<ImuDisagreement> found;
  for (std::size_t d = 0; d < state.drives.size(); ++d) {
    const std::vector<Stretch> stretches = Stretches(dataset, state, sigmas[d], d);
    if (stretches.empty()) continue;
    for (const bool gyroscope : {false, true}) {
      std::vector<double> ratios;
      for (const Stretch& stretch : stretches) ratios.push_back(stretch.Ratio(gyroscope));
      const double limit = std::max(least_ratio, kStandsOut * Median(ratios));
      for (std::size_t s = 0; s < ratios.size(); ++s) {
        if (ratios[s] < limit) continue;
        // What leads there and back is as wrong, if less plainly.
        std::size_t first = s, worst = s, last = s;
        while (first > 0 && ratios[first - 1] >= limit / 2.0) --first;
        for (; last + 1 < ratios.size() && ratios[last + 1] >= limit / 2.0; ++last) {
          if (ratios[last + 1] > ratios[worst]) worst = last + 1;
        }
        found.push_back({d, first * kLength, (last + 1) * kLength, gyroscope,
                         stretches[worst].Mean(gyroscope).norm(), ratios[worst]});
        s = last;
      }
    }
  }
  return found;
}

}  // namespace mlic
