#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <utility>
#include <vector>

#include "mlic_core/result/result.h"

namespace mlic {

// Points of a map by cubic cell; the indices of one cell are ascending.
class VoxelIndex {
 public:
  VoxelIndex(const std::vector<MapPoint>& points, const std::vector<std::uint32_t>& chosen, double size)
      : size_(size) {
    for (const std::uint32_t index : chosen) cells_[Key(CellOf(points[index].position))].push_back(index);
  }

  Eigen::Vector3i CellOf(const Eigen::Vector3f& p) const {
    return (p.cast<double>() / size_).array().floor().cast<int>();
  }

  // The points of one cell; null when there are none.
  const std::vector<std::uint32_t>* Find(const Eigen::Vector3i& cell) const {
    const auto found = cells_.find(Key(cell));
    return found == cells_.end() ? nullptr : &found->second;
  }

  const std::unordered_map<std::uint64_t, std::vector<std::uint32_t>>& Cells() const { return cells_; }

 private:
  static std::uint64_t Key(const Eigen::Vector3i& cell) {
    // from: structural.
    constexpr std::uint64_t kMask = (1u << 21) - 1;  // 21 bits an axis: a million cells each way
    return ((static_cast<std::uint64_t>(cell.x()) & kMask) << 42) |
           ((static_cast<std::uint64_t>(cell.y()) & kMask) << 21) |
           (static_cast<std::uint64_t>(cell.z()) & kMask);
  }

  double size_;
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> cells_;
};

}  // namespace mlic
