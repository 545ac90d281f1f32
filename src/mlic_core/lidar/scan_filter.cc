#include "mlic_core/lidar/scan_filter.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace mlic {
namespace {

constexpr std::size_t kLargest = 12000;  // points that stay of a scan; from: guard, time and memory
constexpr float kNearest = 0.3f;         // m: nearer ones are the housing or the blind zone; from: guard
constexpr float kFarthest = 300.0f;      // m: no LiDAR in use measures farther; from: standard

// Scrambles the index, so that thinning has no beat with the rings (splitmix64's last step).
std::uint32_t Scramble(std::uint32_t index) {
  std::uint64_t z = (index + 1) * 0x9E3779B97F4A7C15ull;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
  return static_cast<std::uint32_t>(z >> 32);
}

}  // namespace

ScanFilterCounts& ScanFilterCounts::operator+=(const ScanFilterCounts& other) {
  kept += other.kept;
  not_finite += other.not_finite;
  too_near += other.too_near;
  too_far += other.too_far;
  thinned_out += other.thinned_out;
  return *this;
}

ScanFilterCounts FilterScan(LidarScan& scan) {
  ScanFilterCounts counts;
  std::vector<std::uint32_t> valid;
  valid.reserve(scan.points.size());
  for (std::size_t i = 0; i < scan.points.size(); ++i) {
    const LidarPoint& point = scan.points[i];
    const float squared_range = point.position.squaredNorm();
    if (!std::isfinite(squared_range) || !std::isfinite(point.time)) {
      ++counts.not_finite;
    } else if (squared_range < kNearest * kNearest) {
      ++counts.too_near;
    } else if (squared_range > kFarthest * kFarthest) {
      ++counts.too_far;
    } else {
      valid.push_back(static_cast<std::uint32_t>(i));
    }
  }
  const double share =
      static_cast<double>(kLargest) / static_cast<double>(std::max<std::size_t>(1, valid.size()));
  std::vector<LidarPoint> kept;
  kept.reserve(std::min(valid.size(), kLargest + kLargest / 8));
  for (const std::uint32_t i : valid) {
    if (share < 1.0 && Scramble(i) >= share * 4294967296.0) continue;
    kept.push_back(scan.points[i]);
  }
  std::stable_sort(kept.begin(), kept.end(),
                   [](const LidarPoint& a, const LidarPoint& b) { return a.time < b.time; });
  scan.points = std::move(kept);
  counts.kept = scan.points.size();
  counts.thinned_out = valid.size() - counts.kept;
  return counts;
}

}  // namespace mlic
