#include "mlic_core/crossmodal/moving_points.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "mlic_core/common/parallel.h"

namespace mlic {
namespace {

// from: derivation, a scan at 10 Hz.
constexpr double kBeamWindow = 0.1;        // s of beams that are looked up together
constexpr std::size_t kMostWindows = 240;  // of all LiDARs; from: guard, time
// from: structural, speed only.
constexpr float kBeamCell = M_PI / 120.0f;          // rad, of the table of a window's beams
constexpr int kBeamColumns = 240, kBeamRows = 120;  // from: structural, cells of kBeamCell over the sphere
// from: guard, beyond, the gaps between beams are as wide as patches.
constexpr float kFarthestPatch = 25.0f;  // m, at which patches are judged
constexpr float kNearestPatch = 1.0f;    // m; from: guard, time: nearer, a patch covers much of the table
// from: guard, a margin of the look-up: half of kBeamWindow at 6 m/s.
constexpr float kParallax = 0.3f;  // m that the LiDAR moves from the middle of a window
constexpr float kGrazingPatch =
    0.1f;                             // cosine: whether such a beam meets a patch cannot be said; from: guard
constexpr float kLeastRadius = 0.2f;  // m
constexpr int kFewestPasses = 3;      // windows whose beams passed
// from: guard, time.
constexpr int kDecided = 8;     // windows that say something, after which a patch that stands is left alone
constexpr double kAside = 0.5;  // s: what is nearer to the hits in time says nothing

// The beams of one LiDAR over a short time, by direction in the map frame from where it was in the middle.
struct BeamTable {
  Eigen::Vector3f origin = Eigen::Vector3f::Zero();
  double time = 0.0;
  std::vector<std::uint32_t> begin;  // of each cell in beams, row by row
  std::vector<std::uint32_t> beams;  // indices of returns
};

void CellOf(const Eigen::Vector3f& v, float length, float* column, float* row) {
  *column = (std::atan2(v.y(), v.x()) + static_cast<float>(M_PI)) / kBeamCell;
  *row = (std::asin(std::clamp(v.z() / length, -1.0f, 1.0f)) + 0.5f * static_cast<float>(M_PI)) / kBeamCell;
}

BeamTable MakeBeamTable(const std::vector<MapReturn>& returns, std::size_t begin, std::size_t end) {
  BeamTable table;
  const MapReturn& middle = returns[(begin + end) / 2];
  table.origin = middle.position - middle.beam;
  table.time = middle.time;
  std::vector<std::uint32_t> cells;
  cells.reserve(end - begin);
  table.begin.assign(kBeamColumns * kBeamRows + 1, 0);
  for (std::size_t i = begin; i < end; ++i) {
    float column, row;
    CellOf(returns[i].beam, returns[i].beam.norm(), &column, &row);
    cells.push_back(std::min(kBeamRows - 1, static_cast<int>(row)) * kBeamColumns +
                    static_cast<int>(column) % kBeamColumns);
    ++table.begin[cells.back() + 1];
  }
  for (std::size_t c = 1; c < table.begin.size(); ++c) table.begin[c] += table.begin[c - 1];
  table.beams.resize(cells.size());
  std::vector<std::uint32_t> next(table.begin.begin(), table.begin.end() - 1);
  for (std::size_t i = begin; i < end; ++i)
    table.beams[next[cells[i - begin]]++] = static_cast<std::uint32_t>(i);
  return table;
}

// Evenly taken over time, in an order that jumps, so that the first ones looked at are from all times.
std::vector<BeamTable> MakeBeamTables(const std::vector<MapReturn>& returns) {
  std::vector<std::pair<std::size_t, std::size_t>> windows;
  for (std::size_t begin = 0; begin < returns.size();) {
    std::size_t end = begin;
    while (end < returns.size() && returns[end].lidar == returns[begin].lidar &&
           std::abs(returns[end].time - returns[begin].time) < kBeamWindow) {
      ++end;
    }
    windows.emplace_back(begin, end);
    begin = end;
  }
  const std::size_t count = std::min(windows.size(), kMostWindows);
  std::vector<BeamTable> tables(count);
  ParallelFor(count, [&](std::size_t k) {
    // The golden section's multiples are spread evenly, however many are taken.
    const double place = std::fmod(0.6180339887498949 * static_cast<double>(k), 1.0);
    const auto& window = windows[static_cast<std::size_t>(place * static_cast<double>(windows.size()))];
    tables[k] = MakeBeamTable(returns, window.first, window.second);
  });
  return tables;
}

struct Patch {
  Eigen::Vector3f center = Eigen::Vector3f::Zero();
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();  // zero: no plane
  float radius = 0.0f;
  std::vector<double> times;  // of its points, in order
};

Patch PatchOf(const std::vector<MapReturn>& returns, const MapSurfaces& surfaces, std::size_t begin,
              std::size_t end) {
  Patch patch;
  Eigen::AlignedBox3f box;
  for (std::size_t k = begin; k < end; ++k) {
    box.extend(surfaces.surfaces[k].position);
    if (patch.normal.isZero()) patch.normal = surfaces.surfaces[k].normal;
    patch.times.push_back(returns[surfaces.order[k]].time);
  }
  std::sort(patch.times.begin(), patch.times.end());
  patch.center = box.center();
  // Within the patch rather than at its corners.
  patch.radius = std::max(kLeastRadius, 0.35f * box.diagonal().norm());
  return patch;
}

enum class Outcome { kNothing, kPassed, kHit };

// What one beam did at a patch.
Outcome BeamAtPatch(const MapReturn& r, const Patch& patch) {
  const float range = r.beam.norm();
  const Eigen::Vector3f direction = r.beam / range, to_center = patch.center - (r.position - r.beam);
  float reach = direction.dot(to_center), margin = 0.3f + patch.radius;
  if (!patch.normal.isZero()) {
    const float cosine = patch.normal.dot(direction);
    if (std::abs(cosine) < kGrazingPatch) return Outcome::kNothing;
    reach = patch.normal.dot(to_center) / cosine;
    margin = 0.2f + 0.1f / std::abs(cosine);
  }
  if (reach < 0.0f || (reach * direction - to_center).norm() > patch.radius) return Outcome::kNothing;
  if (range > reach + margin) return Outcome::kPassed;
  return range > reach - margin ? Outcome::kHit : Outcome::kNothing;
}

Outcome WindowAtPatch(const std::vector<MapReturn>& returns, const BeamTable& table, const Patch& patch) {
  const Eigen::Vector3f v = patch.center - table.origin;
  const float distance = v.norm();
  if (distance > kFarthestPatch || distance < kNearestPatch + patch.radius) return Outcome::kNothing;
  float column, row;
  CellOf(v, distance, &column, &row);
  const float half = (patch.radius + kParallax) / distance / kBeamCell;
  const float half_columns = std::min(20.0f, half / std::max(0.2f, std::hypot(v.x(), v.y()) / distance));
  const int first_row = std::max(0, static_cast<int>(row - half));
  const int last_row = std::min(kBeamRows - 1, static_cast<int>(row + half));
  const int first_column = static_cast<int>(std::floor(column - half_columns));
  const int last_column = static_cast<int>(std::floor(column + half_columns));
  int passed = 0;
  for (int j = first_row; j <= last_row; ++j) {
    for (int i = first_column; i <= last_column; ++i) {
      const int cell = j * kBeamColumns + (i + kBeamColumns) % kBeamColumns;
      for (std::uint32_t b = table.begin[cell]; b < table.begin[cell + 1]; ++b) {
        const Outcome outcome = BeamAtPatch(returns[table.beams[b]], patch);
        if (outcome == Outcome::kHit) return outcome;
        if (outcome == Outcome::kPassed) ++passed;
      }
    }
  }
  return passed >= 2 ? Outcome::kPassed : Outcome::kNothing;
}

bool IsAside(const Patch& patch, double time) {
  const auto next = std::lower_bound(patch.times.begin(), patch.times.end(), time - kAside);
  return next == patch.times.end() || *next > time + kAside;
}

bool IsMoving(const std::vector<MapReturn>& returns, const std::vector<BeamTable>& tables,
              const Patch& patch) {
  int passes = 0, passes_aside = 0, hits = 0;
  for (const BeamTable& table : tables) {
    const Outcome outcome = WindowAtPatch(returns, table, patch);
    if (outcome == Outcome::kHit) ++hits;
    if (outcome == Outcome::kPassed) {
      ++passes;
      if (IsAside(patch, table.time)) ++passes_aside;
    }
    if (hits + passes >= kDecided && hits > passes) return false;
  }
  return passes_aside >= kFewestPasses && 5 * passes_aside >= 4 * passes && 3 * hits <= passes;
}

}  // namespace

std::vector<std::uint8_t> FindMovingPoints(const std::vector<MapReturn>& returns,
                                           const MapSurfaces& surfaces) {
  const std::vector<BeamTable> tables = MakeBeamTables(returns);
  std::vector<std::uint8_t> moving(returns.size(), 0);
  ParallelChunks(surfaces.patches.size() - 1, 1024, [&](std::size_t, std::size_t first, std::size_t last) {
    for (std::size_t p = first; p < last; ++p) {
      const std::size_t begin = surfaces.patches[p], end = surfaces.patches[p + 1];
      if (!IsMoving(returns, tables, PatchOf(returns, surfaces, begin, end))) continue;
      std::fill(moving.begin() + static_cast<std::ptrdiff_t>(begin),
                moving.begin() + static_cast<std::ptrdiff_t>(end), std::uint8_t{1});
    }
  });
  return moving;
}

}  // namespace mlic
