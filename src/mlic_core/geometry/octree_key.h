#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace mlic {

// An octree as sorted keys: the root voxel (kRootBits an axis), then 3 bits for each of kLevels splits.
// Points of one voxel of any level are contiguous in the order of their keys.
struct KeyedIndex {
  std::uint64_t key;
  std::uint32_t index;  // of the point
  bool operator<(const KeyedIndex& other) const {
    return key != other.key ? key < other.key : index < other.index;
  }
};

template <int kRootBits, int kLevels>
struct Octree {
  static_assert(3 * (kRootBits + kLevels) <= 64, "a key has 64 bits");

  // leaf: which of the smallest voxels along each axis, either sign. Root voxels repeat after 2^kRootBits.
  static std::uint64_t KeyOf(const std::array<std::int64_t, 3>& leaf) {
    constexpr std::uint64_t kRootMask = (std::uint64_t{1} << kRootBits) - 1;  // from: derivation
    std::uint64_t key = 0;
    std::array<std::uint64_t, 3> cell;
    for (int a = 0; a < 3; ++a) {
      cell[a] = static_cast<std::uint64_t>(leaf[a] + (std::int64_t{1} << (kRootBits - 1 + kLevels)));
      key = (key << kRootBits) | ((cell[a] >> kLevels) & kRootMask);
    }
    for (int level = kLevels - 1; level >= 0; --level) {
      for (int a = 0; a < 3; ++a) key = (key << 1) | ((cell[a] >> level) & 1);
    }
    return key;
  }

  // The key of the root voxel that a point's key is in.
  static std::uint64_t RootOf(std::uint64_t key) { return key >> (3 * kLevels); }

  // use(begin, end) for each occupied child of the voxel that is [begin, end) of `keyed`; level: its own, 0
  // for a root, less than kLevels.
  template <typename Use>
  static void ForEachChild(const std::vector<KeyedIndex>& keyed, std::size_t begin, std::size_t end,
                           int level, const Use& use) {
    const int shift = 3 * (kLevels - 1 - level);
    for (std::size_t child = begin; child < end;) {
      std::size_t next = child + 1;
      while (next < end && keyed[next].key >> shift == keyed[child].key >> shift) ++next;
      use(child, next);
      child = next;
    }
  }
};

}  // namespace mlic
