#include "mlic_core/inspection/azimuth_rate.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace mlic {
namespace {

constexpr double kLeastSweep = 300.0 * M_PI / 180.0;  // rad; from: guard, a revolution less what sees nothing
constexpr double kLargestResidual = 0.02;             // rad, rms; from: guard, a motor's rate is steady
constexpr std::size_t kFewestPointsOfRate = 50;       // from: guard

std::vector<LidarPoint> FullestRing(const std::vector<LidarPoint>& points) {
  std::map<std::uint16_t, std::size_t> counts;
  for (const LidarPoint& p : points) ++counts[p.ring];
  std::vector<LidarPoint> ring;
  if (counts.size() < 2) return ring;
  const auto fullest = std::max_element(counts.begin(), counts.end(),
                                        [](const auto& a, const auto& b) { return a.second < b.second; });
  for (const LidarPoint& p : points) {
    if (p.ring == fullest->first) ring.push_back(p);
  }
  std::stable_sort(ring.begin(), ring.end(), [](const auto& a, const auto& b) { return a.time < b.time; });
  return ring;
}

// In order, without the jumps from pi to -pi.
std::vector<double> Unwrapped(const std::vector<LidarPoint>& ring) {
  std::vector<double> azimuths;
  for (const LidarPoint& p : ring) {
    double azimuth = std::atan2(p.position.y(), p.position.x());
    if (!azimuths.empty()) azimuth += 2.0 * M_PI * std::round((azimuths.back() - azimuth) / (2.0 * M_PI));
    azimuths.push_back(azimuth);
  }
  return azimuths;
}

}  // namespace

std::optional<AzimuthRate> MeasureAzimuthRate(const std::vector<LidarPoint>& points) {
  const std::vector<LidarPoint> ring = FullestRing(points);
  if (ring.size() < kFewestPointsOfRate || !(ring.back().time > ring.front().time)) return std::nullopt;
  const std::vector<double> azimuths = Unwrapped(ring);
  const double count = static_cast<double>(ring.size());
  double mean_time = 0.0, mean_azimuth = 0.0, moment = 0.0, product = 0.0, squares = 0.0;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    mean_time += ring[i].time / count;
    mean_azimuth += azimuths[i] / count;
  }
  for (std::size_t i = 0; i < ring.size(); ++i) {
    moment += (ring[i].time - mean_time) * (ring[i].time - mean_time);
    product += (ring[i].time - mean_time) * (azimuths[i] - mean_azimuth);
  }
  const double rate = product / moment;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const double residual = azimuths[i] - mean_azimuth - rate * (ring[i].time - mean_time);
    squares += residual * residual;
  }
  const double sweep = ring.back().time - ring.front().time;
  if (std::abs(rate * sweep) < kLeastSweep || std::sqrt(squares / count) > kLargestResidual) {
    return std::nullopt;
  }
  return AzimuthRate{rate, sweep};
}

}  // namespace mlic
