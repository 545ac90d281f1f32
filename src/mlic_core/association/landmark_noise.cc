#include "mlic_core/association/landmark_noise.h"

#include <algorithm>
#include <cmath>

#include "mlic_core/problem/landmark_terms.h"

namespace mlic {
namespace {

constexpr double kMedianOfNorm = 1.1774;  // of a standard normal 2-vector; from: derivation
// from: derivation, 4.7 sigma.
constexpr double kLargestNorm = 4.0;     // of a whitened residual that counts, in medians of normal ones
constexpr double kMostCorrelated = 0.7;  // from: guard, against the pole of (1 + r) / (1 - r)

// A whitened residual and the landmark's previous one of the same camera.
struct Whitened {
  Eigen::Vector2d value;
  double spread;                                       // of it for white noise of one, points being fitted
  double follows = 0.0;                                // 1 with a previous one
  Eigen::Vector2d previous = Eigen::Vector2d::Zero();  // likewise whitened
  double shared = 0.0;                                 // what the fit makes the two share, of the variance
};

// Points take up three of the residuals of a landmark: with few observations they look better than they are,
// and what the point takes up is about the same of neighbouring observations.
void Collect(const LandmarkSet& set, const std::vector<Eigen::Vector2d>& residuals, bool noise_of_each,
             std::vector<std::vector<Whitened>>* of_cameras) {
  for (std::size_t p = 0; p < set.points.size(); ++p) {
    if (set.IsOnMap(p)) continue;
    const double observations = static_cast<double>(set.begin[p + 1] - set.begin[p]);
    // Single observations are no worse for being many.
    const double many = noise_of_each ? ManyObservationsScale(set.begin[p + 1] - set.begin[p]) : 1.0;
    for (std::size_t k = set.begin[p]; k < set.begin[p + 1]; ++k) {
      if (!residuals[k].allFinite()) continue;
      const LandmarkObservation& o = set.observations[k];
      Whitened w{many * residuals[k] / o.sigma, std::sqrt((2.0 * observations - 3.0) / (2.0 * observations))};
      if (k > set.begin[p] && residuals[k - 1].allFinite() && set.observations[k - 1].camera == o.camera) {
        w.follows = 1.0;
        w.previous = many * residuals[k - 1] / set.observations[k - 1].sigma;
        w.shared = -2.4 / observations;
      }
      (*of_cameras)[o.camera].push_back(w);
    }
  }
}

// The spread of the many is their median's. By how much the noise of their mean exceeds it: what the spread
// without the outliers adds, and the correlation of neighbouring observations of a landmark (first-order
// autoregressive), which share what their patch has in common.
LandmarkNoise NoiseOf(const std::vector<Whitened>& residuals) {
  std::vector<double> norms;
  for (const Whitened& w : residuals) norms.push_back(w.value.norm() / w.spread);
  const auto middle = norms.begin() + static_cast<std::ptrdiff_t>(norms.size() / 2);
  std::nth_element(norms.begin(), middle, norms.end());
  const double spread = *middle / kMedianOfNorm, limit = kLargestNorm * spread;
  double squares = 0.0, freedom = 1e-12;
  for (const Whitened& w : residuals) {
    if (w.value.norm() > limit * w.spread) continue;
    squares += w.value.squaredNorm();
    freedom += 2.0 * w.spread * w.spread;
  }
  const double variance = squares / freedom;
  double product = 0.0, pairs = 1e-12;
  for (const Whitened& w : residuals) {
    if (w.follows == 0.0 || w.value.norm() > limit || w.previous.norm() > limit) continue;
    product += w.value.dot(w.previous) - variance * w.shared;
    pairs += 2.0;
  }
  const double correlation =
      variance > 0.0 ? std::clamp(product / (pairs * variance), 0.0, kMostCorrelated) : 0.0;
  const double noise = std::sqrt(variance * (1.0 + correlation) / (1.0 - correlation));
  return {spread, spread > 0.0 ? std::max(1.0, noise / spread) : 1.0};
}

}  // namespace

std::vector<LandmarkNoise> MeasureLandmarkNoise(const std::vector<DriveTerms>& drives,
                                                const CalibrationState& state,
                                                const LandmarkOptions& made_with, double least) {
  std::vector<std::vector<Whitened>> residuals(state.cameras.size());
  for (std::size_t d = 0; d < drives.size(); ++d) {
    const LandmarkSet& set = drives[d].landmarks;
    Collect(set, LandmarkResiduals(set, state, d), made_with.noise_of_each, &residuals);
  }
  std::vector<LandmarkNoise> noise(state.cameras.size(), {least, 1.0});
  for (std::size_t c = 0; c < noise.size(); ++c) {
    if (residuals[c].empty()) continue;
    const LandmarkNoise made = made_with.noise.empty() ? LandmarkNoise() : made_with.noise[c];
    noise[c] = NoiseOf(residuals[c]);
    noise[c].spread = std::max(least, made.spread * made.dependence * noise[c].spread);
  }
  return noise;
}

}  // namespace mlic
