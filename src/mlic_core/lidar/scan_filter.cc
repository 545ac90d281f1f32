#include "mlic_core/lidar/scan_filter.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace mlic {
namespace {

constexpr float kVoxels[] = {0.2f, 0.1f, 0.05f};  // m, the first that leaves enough points
constexpr std::size_t kEnough = 5000;
constexpr float kNearest = 0.3f;  // m: nearer ones are the housing or the blind zone
constexpr float kFarthest =
    300.0f;  // m: no LiDAR in use measures farther; far enough for 20-bit voxel numbers

constexpr std::uint32_t kEmpty = 0xFFFFFFFFu;

std::uint64_t VoxelKey(const Eigen::Vector3f& p, float inverse_voxel) {
  // Shifted to positive numbers, where truncation is the floor.
  constexpr float kShift = 524288.0f;
  const auto number = [&](float x) {
    return static_cast<std::uint64_t>(std::floor(x * inverse_voxel) + kShift);
  };
  return number(p.x()) | (number(p.y()) << 20) | (number(p.z()) << 40);
}

// For each voxel the earliest point of it. Open addressing with linear probing, at most half full.
class EarliestInVoxel {
 public:
  explicit EarliestInVoxel(std::size_t points) {
    while ((std::size_t{1} << bits_) < 2 * points) ++bits_;
    slots_.resize(std::size_t{1} << bits_);
  }

  // Enters points[index] under the key; of two with the same time the first in the message stays.
  void Enter(std::uint64_t key, std::uint32_t index, const std::vector<LidarPoint>& points) {
    std::size_t slot = (key * 0x9E3779B97F4A7C15ull) >> (64 - bits_);
    while (slots_[slot].index != kEmpty && slots_[slot].key != key) slot = (slot + 1) & (slots_.size() - 1);
    Slot& entry = slots_[slot];
    if (entry.index == kEmpty) {
      entry = {key, index};
      used_.push_back(static_cast<std::uint32_t>(slot));
    } else if (points[index].time < points[entry.index].time) {
      entry.index = index;
    }
  }

  std::size_t size() const { return used_.size(); }

  std::vector<LidarPoint> Take(const std::vector<LidarPoint>& points) const {
    struct Order {
      float time;
      std::uint32_t index;
      bool operator<(const Order& other) const {
        return time != other.time ? time < other.time : index < other.index;
      }
    };
    std::vector<Order> order;
    order.reserve(used_.size());
    for (const std::uint32_t slot : used_)
      order.push_back({points[slots_[slot].index].time, slots_[slot].index});
    std::sort(order.begin(), order.end());
    std::vector<LidarPoint> kept;
    kept.reserve(order.size());
    for (const Order& entry : order) kept.push_back(points[entry.index]);
    return kept;
  }

 private:
  struct Slot {
    std::uint64_t key = 0;
    std::uint32_t index = kEmpty;
  };
  int bits_ = 4;
  std::vector<Slot> slots_;
  std::vector<std::uint32_t> used_;
};

}  // namespace

ScanFilterCounts& ScanFilterCounts::operator+=(const ScanFilterCounts& other) {
  kept += other.kept;
  not_finite += other.not_finite;
  too_near += other.too_near;
  too_far += other.too_far;
  duplicates += other.duplicates;
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
  std::vector<LidarPoint> kept;
  for (const float voxel : kVoxels) {
    EarliestInVoxel voxels(valid.size());
    for (const std::uint32_t i : valid) {
      voxels.Enter(VoxelKey(scan.points[i].position, 1.0f / voxel), i, scan.points);
    }
    if (voxels.size() >= kEnough || voxels.size() == valid.size() || voxel == kVoxels[2]) {
      kept = voxels.Take(scan.points);
      break;
    }
  }
  scan.points = std::move(kept);
  counts.kept = scan.points.size();
  counts.duplicates = valid.size() - counts.kept;
  return counts;
}

}  // namespace mlic
