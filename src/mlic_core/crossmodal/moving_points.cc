#include "mlic_core/crossmodal/moving_points.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mlic_core/common/parallel.h"

namespace mlic {
namespace {

constexpr double kWindow = 0.05;           // s of beams that are looked at together
constexpr std::size_t kMostWindows = 500;  // of all LiDARs
constexpr float kCell = M_PI / 180.0f;     // rad, of a range image
constexpr int kColumns = 360, kRows = 180;
constexpr float kFarthest = 25.0f;  // m: beyond, patches are smaller than the gaps between beams
constexpr float kNearest = 1.0f;    // m
constexpr float kMargin = 0.4f;     // m: beams must end this much behind a patch to have passed it
constexpr int kFewestBeams = 4;     // past a patch
constexpr int kFewestPasses = 3;
constexpr double kAside = 0.5;  // s: what is nearer to the hits in time says nothing

// Shortest ranges by direction (map frame) of the beams of one LiDAR over a short time.
struct RangeImage {
  Eigen::Vector3f origin = Eigen::Vector3f::Zero();
  double time = 0.0;
  std::vector<float> shortest;
  std::vector<std::uint8_t> count;
};

void Direction(const Eigen::Vector3f& v, float range, float* column, float* row) {
  *column = (std::atan2(v.y(), v.x()) + static_cast<float>(M_PI)) / kCell;
  *row = (std::asin(std::clamp(v.z() / range, -1.0f, 1.0f)) + 0.5f * static_cast<float>(M_PI)) / kCell;
}

RangeImage MakeRangeImage(const std::vector<MapReturn>& returns, std::size_t begin, std::size_t end) {
  RangeImage image;
  const MapReturn& middle = returns[(begin + end) / 2];
  image.origin = middle.position - middle.beam;
  image.time = middle.time;
  image.shortest.assign(kColumns * kRows, std::numeric_limits<float>::infinity());
  image.count.assign(kColumns * kRows, 0);
  for (std::size_t i = begin; i < end; ++i) {
    // Its place as seen from the middle: beams and patches are compared from one point.
    const Eigen::Vector3f v = returns[i].position - image.origin;
    const float range = v.norm();
    float column, row;
    Direction(v, range, &column, &row);
    const int cell =
        std::min(kRows - 1, static_cast<int>(row)) * kColumns + static_cast<int>(column) % kColumns;
    image.shortest[cell] = std::min(image.shortest[cell], range);
    if (image.count[cell] < 255) ++image.count[cell];
  }
  return image;
}

std::vector<RangeImage> MakeRangeImages(const std::vector<MapReturn>& returns) {
  std::vector<std::pair<std::size_t, std::size_t>> windows;
  for (std::size_t begin = 0; begin < returns.size();) {
    std::size_t end = begin;
    while (end < returns.size() && returns[end].lidar == returns[begin].lidar &&
           std::abs(returns[end].time - returns[begin].time) < kWindow) {
      ++end;
    }
    windows.emplace_back(begin, end);
    begin = end;
  }
  const std::size_t step = 1 + windows.size() / kMostWindows;
  std::vector<RangeImage> images((windows.size() + step - 1) / step);
  ParallelFor(images.size(), [&](std::size_t k) {
    images[k] = MakeRangeImage(returns, windows[k * step].first, windows[k * step].second);
  });
  return images;
}

struct Patch {
  Eigen::Vector3f center = Eigen::Vector3f::Zero();
  float radius = 0.0f;
  double first = 0.0, last = 0.0;  // time of its hits
};

Patch PatchOf(const std::vector<MapReturn>& returns, const MapSurfaces& surfaces, std::size_t begin,
              std::size_t end) {
  Patch patch;
  Eigen::AlignedBox3f box;
  patch.first = std::numeric_limits<double>::infinity();
  patch.last = -patch.first;
  for (std::size_t k = begin; k < end; ++k) {
    box.extend(surfaces.surfaces[k].position);
    const double time = returns[surfaces.order[k]].time;
    patch.first = std::min(patch.first, time);
    patch.last = std::max(patch.last, time);
  }
  patch.center = box.center();
  patch.radius = 0.5f * box.diagonal().norm();
  return patch;
}

enum class Look { kNothing, kPassed, kHit };

Look LookAtPatch(const RangeImage& image, const Patch& patch) {
  const Eigen::Vector3f v = patch.center - image.origin;
  const float distance = v.norm();
  if (distance > kFarthest || distance < kNearest) return Look::kNothing;
  float column, row;
  Direction(v, distance, &column, &row);
  const float half = patch.radius / distance / kCell + 0.75f;
  const float half_columns = half / std::max(0.2f, std::hypot(v.x(), v.y()) / distance);
  const int first_row = std::max(0, static_cast<int>(row - half));
  const int last_row = std::min(kRows - 1, static_cast<int>(row + half));
  const int first_column = static_cast<int>(std::floor(column - half_columns));
  const int last_column = static_cast<int>(std::floor(column + half_columns));
  float shortest = std::numeric_limits<float>::infinity();
  int beams = 0;
  for (int j = first_row; j <= last_row; ++j) {
    for (int i = first_column; i <= last_column; ++i) {
      const int cell = j * kColumns + (i + kColumns) % kColumns;
      shortest = std::min(shortest, image.shortest[cell]);
      beams += image.count[cell];
    }
  }
  const float margin = kMargin + patch.radius;
  if (beams >= kFewestBeams && shortest > distance + margin) return Look::kPassed;
  return beams > 0 && std::abs(shortest - distance) < margin ? Look::kHit : Look::kNothing;
}

}  // namespace

std::vector<std::uint8_t> FindMovingPoints(const std::vector<MapReturn>& returns,
                                           const MapSurfaces& surfaces) {
  const std::vector<RangeImage> images = MakeRangeImages(returns);
  std::vector<std::uint8_t> moving(returns.size(), 0);
  ParallelChunks(surfaces.patches.size() - 1, 1024, [&](std::size_t, std::size_t first, std::size_t last) {
    for (std::size_t p = first; p < last; ++p) {
      const std::size_t begin = surfaces.patches[p], end = surfaces.patches[p + 1];
      const Patch patch = PatchOf(returns, surfaces, begin, end);
      int passes = 0, passes_aside = 0, hits = 0;
      for (const RangeImage& image : images) {
        const Look look = LookAtPatch(image, patch);
        if (look == Look::kHit) ++hits;
        if (look != Look::kPassed) continue;
        ++passes;
        if (image.time < patch.first - kAside || image.time > patch.last + kAside) ++passes_aside;
      }
      if (passes_aside < kFewestPasses || 5 * passes_aside < 4 * passes || hits > passes / 3) continue;
      std::fill(moving.begin() + static_cast<std::ptrdiff_t>(begin),
                moving.begin() + static_cast<std::ptrdiff_t>(end), std::uint8_t{1});
    }
  });
  return moving;
}

}  // namespace mlic
