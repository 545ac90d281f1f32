#include "mlic_core/geometry/octree_key.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

namespace mlic::octree_key_test {
namespace {

using Small = Octree<4, 2>;  // 16 root voxels an axis, each of 4 leaves an axis

std::vector<KeyedIndex> Sorted(const std::vector<std::array<std::int64_t, 3>>& leaves) {
  std::vector<KeyedIndex> keyed;
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    keyed.push_back({Small::KeyOf(leaves[i]), static_cast<std::uint32_t>(i)});
  }
  std::sort(keyed.begin(), keyed.end());
  return keyed;
}

TEST(Octree, LeavesOfOneVoxelShareItsKeyAndOthersDoNot) {
  const auto root = [](std::int64_t x, std::int64_t y, std::int64_t z) {
    return Small::RootOf(Small::KeyOf({x, y, z}));
  };
  EXPECT_EQ(root(0, 0, 0), root(3, 3, 3));
  EXPECT_EQ(root(-1, -1, -1), root(-4, -4, -4));
  EXPECT_NE(root(0, 0, 0), root(4, 0, 0));
  EXPECT_NE(root(0, 0, 0), root(-1, 0, 0));
  EXPECT_NE(root(0, 0, 4), root(0, 4, 0));
  EXPECT_NE(Small::KeyOf({0, 0, 0}), Small::KeyOf({0, 0, 1}));
}

TEST(Octree, ChildrenAreTheOccupiedOctantsInOrder) {
  // Two points in one octant of the voxel at 0, one in the opposite octant.
  const std::vector<KeyedIndex> keyed = Sorted({{3, 3, 3}, {0, 1, 0}, {1, 0, 1}});
  std::vector<std::pair<std::size_t, std::size_t>> children, leaves;
  Small::ForEachChild(keyed, 0, 3, 0,
                      [&](std::size_t begin, std::size_t end) { children.emplace_back(begin, end); });
  ASSERT_EQ(children.size(), 2u);
  EXPECT_EQ(children[0], std::make_pair(std::size_t{0}, std::size_t{2}));
  EXPECT_EQ(children[1], std::make_pair(std::size_t{2}, std::size_t{3}));
  EXPECT_EQ(keyed[2].index, 0u);
  Small::ForEachChild(keyed, 0, 2, 1,
                      [&](std::size_t begin, std::size_t end) { leaves.emplace_back(begin, end); });
  EXPECT_EQ(leaves.size(), 2u);
}

}  // namespace
}  // namespace mlic::octree_key_test
