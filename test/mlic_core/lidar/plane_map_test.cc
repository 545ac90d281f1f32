#include "mlic_core/lidar/plane_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <utility>
#include <vector>

#include "mlic_core/common/random.h"

namespace mlic::plane_map_test {
namespace {

constexpr double kNoise = 0.02;  // m
const std::vector<PlaneNoise> kNoises{{kNoise, 0.001}};

// A floor patch of 6 x 6 m at `height`, seen from above in ten scans from `start` on, one second apart.
void SeeFloor(double height, double start, int first_scan, Random* random, std::vector<MapSample>* samples) {
  for (int scan = 0; scan < 10; ++scan) {
    for (int i = 0; i < 2000; ++i) {
      MapSample sample;
      sample.position = Eigen::Vector3d(random->Uniform(0.0, 6.0), random->Uniform(0.0, 6.0),
                                        height + kNoise * random->Normal())
                            .cast<float>();
      sample.view = Eigen::Vector3f::UnitZ();
      sample.time = start + scan;
      sample.scan = first_scan + scan;
      sample.index = i;
      samples->push_back(sample);
    }
  }
}

double LargestOffset(const std::vector<MapPlane>& planes, double height) {
  double largest = 0.0;
  for (const MapPlane& plane : planes) largest = std::max(largest, std::abs(plane.center.z() - height));
  return largest;
}

// Wherever a floor lies in the grid of voxels, each of its patches holds both halves of the noise.
TEST(PlaneMap, IsNotBiasedByTheGridAtAnyHeight) {
  for (const double height : {0.0, 0.25, 0.5, 1.0, 1.0001, 2.0, -3.0}) {
    Random random(1);
    std::vector<MapSample> samples;
    SeeFloor(height, 0.0, 0, &random, &samples);
    const std::vector<MapPlane> planes = BuildPlaneMap(samples, kNoises, {});
    ASSERT_GT(planes.size(), 4u) << height;
    std::size_t members = 0;
    for (const MapPlane& plane : planes) members += plane.samples.size();
    EXPECT_GT(members, samples.size() * 97 / 100) << height;
    // Large patches average the noise away; halves of it would lie 16 mm off.
    for (const MapPlane& plane : planes) {
      if (plane.samples.size() < 400) continue;
      EXPECT_LT(std::abs(plane.center.z() - height), 0.005) << height;
    }
  }
}

// The second visit sees the floor 5 cm higher, as where the trajectory has drifted.
TEST(PlaneMap, FitsEachVisitByItself) {
  Random random(2);
  std::vector<MapSample> samples;
  SeeFloor(0.3, 0.0, 0, &random, &samples);
  SeeFloor(0.35, 100.0, 10, &random, &samples);
  PlaneMapOptions options;
  options.longest = 20.0;
  std::vector<MapPlane> first, second;
  double last_start = 0.0;
  for (const MapPlane& plane : BuildPlaneMap(samples, kNoises, options)) {
    EXPECT_GE(plane.start, last_start);
    last_start = plane.start;
    for (const std::uint32_t s : plane.samples) {
      EXPECT_GE(samples[s].time, plane.start);
      EXPECT_LE(samples[s].time, plane.start + options.longest);
    }
    if (plane.samples.size() >= 400) (plane.start < 50.0 ? first : second).push_back(plane);
  }
  ASSERT_GT(first.size(), 4u);
  ASSERT_GT(second.size(), 4u);
  EXPECT_LT(LargestOffset(first, 0.3), 0.005);
  EXPECT_LT(LargestOffset(second, 0.35), 0.005);
}

// Gravel: it lies in larger patches whose points count for less, not in crumbs.
TEST(PlaneMap, TakesARoughSurfaceForARoughPlane) {
  Random random(4);
  std::vector<MapSample> samples;
  SeeFloor(0.3, 0.0, 0, &random, &samples);
  for (MapSample& sample : samples) sample.position.z() += static_cast<float>(0.03 * random.Normal());
  std::size_t members = 0;
  for (const MapPlane& plane : BuildPlaneMap(samples, kNoises, {})) {
    members += plane.samples.size();
    if (plane.samples.size() < 400) continue;
    EXPECT_GT(plane.inflation, 1.3);
    EXPECT_LT(std::abs(plane.center.z() - 0.3), 0.01);
  }
  EXPECT_GT(members, samples.size() * 8 / 10);
}

std::vector<std::uint64_t> VoxelsOf(const std::vector<MapPlane>& planes) {
  std::vector<std::uint64_t> voxels;
  for (const MapPlane& plane : planes) voxels.push_back(plane.voxel);
  std::sort(voxels.begin(), voxels.end());
  return voxels;
}

// Gravel as rough as planes may be: by the draw of its points a voxel is one plane or splits.
TEST(PlaneMap, KeepsToThePlanesOfTheMapBefore) {
  const auto draw = [](std::uint64_t seed, std::vector<std::uint64_t> last_voxels) {
    Random random(seed);
    std::vector<MapSample> samples;
    SeeFloor(0.3, 0.0, 0, &random, &samples);
    for (MapSample& sample : samples) {
      sample.position.z() += static_cast<float>(std::sqrt(8.0) * kNoise * random.Normal());
    }
    PlaneMapOptions options;
    options.last_voxels = std::move(last_voxels);
    return VoxelsOf(BuildPlaneMap(samples, kNoises, options));
  };
  const std::vector<std::uint64_t> first = draw(5, {});
  ASSERT_GT(first.size(), 4u);
  EXPECT_EQ(std::adjacent_find(first.begin(), first.end()), first.end()) << "a voxel is one plane";
  const auto changes = [&](std::uint64_t seed, const std::vector<std::uint64_t>& last_voxels) {
    std::vector<std::uint64_t> changed;
    const std::vector<std::uint64_t> now = draw(seed, last_voxels);
    std::set_symmetric_difference(first.begin(), first.end(), now.begin(), now.end(),
                                  std::back_inserter(changed));
    return changed.size();
  };
  std::size_t by_draw = 0, kept = 0;
  for (std::uint64_t seed = 6; seed < 16; ++seed) {
    by_draw += changes(seed, {});
    kept += changes(seed, first);
  }
  EXPECT_LT(3 * kept, by_draw) << kept;
}

// Both sides of a panel 1 cm thick: one plane for each, though one fit would take both.
TEST(PlaneMap, KeepsTheSidesOfAThinPanelApart) {
  Random random(3);
  std::vector<MapSample> samples;
  SeeFloor(0.305, 0.0, 0, &random, &samples);
  const std::size_t upper = samples.size();
  SeeFloor(0.295, 0.0, 10, &random, &samples);
  for (std::size_t i = upper; i < samples.size(); ++i) samples[i].view = -Eigen::Vector3f::UnitZ();
  std::size_t up = 0, down = 0;
  for (const MapPlane& plane : BuildPlaneMap(samples, kNoises, {})) {
    if (plane.samples.size() < 400) continue;
    const bool is_up = plane.plane.normal.z() > 0.0;
    (is_up ? up : down) += 1;
    EXPECT_NEAR(plane.center.z(), is_up ? 0.305 : 0.295, 0.004);
    for (const std::uint32_t s : plane.samples) EXPECT_EQ(s < upper, is_up);
  }
  EXPECT_GT(up, 4u);
  EXPECT_GT(down, 4u);
}

// A wall with ribs that stand 0.2 m out of it, one for each metre, seen in ten scans. What of the ribs lies
// within the wall's gate is all on one side of it and would draw the wall by some tenth of the noise.
TEST(PlaneMap, IsNotDrawnByWhatStandsOnIt) {
  Random random(4);
  const Eigen::Vector3d sensor(3.0, 3.0, 1.5);
  std::vector<MapSample> samples;
  for (int scan = 0; scan < 10; ++scan) {
    for (int i = 0; i < 6000; ++i) {
      const double along = random.Uniform(0.0, 6.0), up = random.Uniform(0.0, 3.0);
      const Eigen::Vector3d hit = i % 10 == 0
                                      ? Eigen::Vector3d(random.Uniform(0.0, 0.2), std::floor(along) + 0.5, up)
                                      : Eigen::Vector3d(0.0, along, up);
      MapSample sample;
      const Eigen::Vector3d view = (sensor - hit).normalized();
      sample.position = (hit + kNoise * random.Normal() * view).cast<float>();
      sample.view = view.cast<float>();
      sample.time = scan;
      sample.scan = scan;
      sample.index = i;
      samples.push_back(sample);
    }
  }
  double drawn = 0.0, points = 0.0;
  for (const MapPlane& plane : BuildPlaneMap(samples, kNoises, {})) {
    if (std::abs(plane.plane.normal.x()) < 0.9) continue;
    drawn += static_cast<double>(plane.samples.size()) * plane.center.x();
    points += static_cast<double>(plane.samples.size());
  }
  ASSERT_GT(points, 20000.0);
  EXPECT_LT(std::abs(drawn / points), 0.02 * kNoise);
}

// A floor with hollows of 0.6 m, 5 cm deep: 2.5 sigmas, so that they lie within its gate.
TEST(PlaneMap, IsNotDrawnByWindows) {
  constexpr double kHeight = 0.3, kDepth = 0.05;
  const auto is_hollow = [](const Eigen::Vector3f& p) {
    return std::fmod(p.x(), 1.5) < 0.6 && std::fmod(p.y(), 1.2) < 0.6;
  };
  Random random(5);
  std::vector<MapSample> samples;
  SeeFloor(kHeight, 0.0, 0, &random, &samples);
  for (MapSample& sample : samples) {
    if (is_hollow(sample.position)) sample.position.z() -= static_cast<float>(kDepth);
  }
  double drawn = 0.0, points = 0.0, hollow = 0.0;
  for (const MapPlane& plane : BuildPlaneMap(samples, kNoises, {})) {
    if (std::abs(plane.center.z() - kHeight) > 0.5 * kDepth) continue;  // of a hollow alone
    for (const std::uint32_t s : plane.samples) {
      points += 1.0;
      hollow += is_hollow(samples[s].position) ? 1.0 : 0.0;
      drawn += samples[s].position.z() - kHeight;
    }
  }
  ASSERT_GT(points, 0.5 * samples.size());
  EXPECT_LT(hollow, 0.02 * points);
  EXPECT_LT(std::abs(drawn / points), 0.05 * kNoise);
}

}  // namespace
}  // namespace mlic::plane_map_test
