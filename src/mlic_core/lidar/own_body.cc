#include "mlic_core/lidar/own_body.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace mlic {
namespace {

constexpr double kReach = 4.0;      // m; from: guard, own bodies end before; what reaches on is kept
constexpr double kNearCell = 0.2;   // m
constexpr double kFarCell = 1.0;    // m; from: guard, only tells a stand from motion
constexpr double kFarReach = 30.0;  // m; from: guard, memory
// from: guard, nearly all of the own body, few of what is passed.
constexpr double kMostScans = 0.7;  // share of the scans that see what never moves
// from: guard, nearly all at rest, few in motion.
constexpr double kStandingShare = 0.9;          // of the far points where nothing moves at all
constexpr std::size_t kFewestScansOfBody = 30;  // from: guard

// Cells of a cube about the sensor, each with the number of scans that have a point in it.
class ScanCounts {
 public:
  ScanCounts(double cell, double reach)
      : cell_(cell), size_(2 * static_cast<int>(std::ceil(reach / cell))), cells_(size_ * size_ * size_) {}

  int size() const { return size_; }
  int count() const { return static_cast<int>(cells_.size()); }
  // The cell of a place, -1 for none.
  int Index(const Eigen::Vector3f& p) const {
    int index = 0;
    for (int a = 0; a < 3; ++a) {
      const int at = static_cast<int>(std::floor(p[a] / cell_)) + size_ / 2;
      if (at < 0 || at >= size_) return -1;
      index = index * size_ + at;
    }
    return index;
  }
  Eigen::Vector3i Place(int index) const {
    return {index / (size_ * size_), index / size_ % size_, index % size_};
  }
  Eigen::Vector3d Center(int index) const {
    return ((Place(index).cast<double>().array() + 0.5 - 0.5 * size_) * cell_).matrix();
  }
  // Calls visit(index) for the cells that touch this one.
  template <typename Visit>
  void Neighbours(int index, const Visit& visit) const {
    const Eigen::Vector3i place = Place(index);
    for (int k = 0; k < 27; ++k) {
      const Eigen::Vector3i p = place + Eigen::Vector3i(k / 9 - 1, k / 3 % 3 - 1, k % 3 - 1);
      if (k == 13 || p.minCoeff() < 0 || p.maxCoeff() >= size_) continue;
      visit((p.x() * size_ + p.y()) * size_ + p.z());
    }
  }

  void See(int index, std::int32_t scan) {
    Cell& cell = cells_[index];
    if (cell.last == scan) return;
    cell.last = scan;
    ++cell.scans;
  }
  bool Persists(int index, std::size_t scans) const {
    return cells_[index].scans >= kMostScans * static_cast<double>(scans);
  }

 private:
  struct Cell {
    std::int32_t last = -1;
    std::int32_t scans = 0;
  };
  double cell_;
  int size_;
  std::vector<Cell> cells_;
};

// Whether what is far stays where it is: then nothing can be told apart.
bool StandsStill(const ScanCounts& far, const std::vector<LidarScan>& scans) {
  double points = 0.0, persistent = 0.0;
  for (const LidarScan& scan : scans) {
    for (const LidarPoint& point : scan.points) {
      const int index = point.position.norm() > kReach ? far.Index(point.position) : -1;
      if (index < 0) continue;
      points += 1.0;
      if (far.Persists(index, scans.size())) persistent += 1.0;
    }
  }
  return points == 0.0 || persistent > kStandingShare * points;
}

// The persistent cells that hang together and end within reach, with the cells around them.
std::vector<bool> BodyCells(const ScanCounts& near, std::size_t scans) {
  std::vector<bool> visited(near.count(), false), body(near.count(), false);
  for (int start = 0; start < near.count(); ++start) {
    if (visited[start] || !near.Persists(start, scans)) continue;
    std::vector<int> part{start};
    visited[start] = true;
    bool reaches_on = false;
    for (std::size_t k = 0; k < part.size(); ++k) {
      reaches_on |= near.Center(part[k]).norm() > kReach - 2.0 * kNearCell;
      near.Neighbours(part[k], [&](int next) {
        if (visited[next] || !near.Persists(next, scans)) return;
        visited[next] = true;
        part.push_back(next);
      });
    }
    if (reaches_on) continue;
    for (const int cell : part) {
      body[cell] = true;
      near.Neighbours(cell, [&](int next) { body[next] = true; });
    }
  }
  return body;
}

}  // namespace

std::size_t RemoveOwnBody(LidarRecording* recording) {
  std::vector<LidarScan>& scans = recording->scans;
  if (scans.size() < kFewestScansOfBody) return 0;
  ScanCounts near(kNearCell, kReach), far(kFarCell, kFarReach);
  for (std::size_t s = 0; s < scans.size(); ++s) {
    for (const LidarPoint& point : scans[s].points) {
      ScanCounts& counts = point.position.norm() > kReach ? far : near;
      const int index = counts.Index(point.position);
      if (index >= 0) counts.See(index, static_cast<std::int32_t>(s));
    }
  }
  const std::vector<bool> body = BodyCells(near, scans.size());
  if (std::find(body.begin(), body.end(), true) == body.end() || StandsStill(far, scans)) return 0;
  std::size_t removed = 0;
  for (LidarScan& scan : scans) {
    const auto kept = std::remove_if(scan.points.begin(), scan.points.end(), [&](const LidarPoint& point) {
      if (point.position.norm() > kReach) return false;
      const int index = near.Index(point.position);
      return index >= 0 && body[index];
    });
    removed += static_cast<std::size_t>(scan.points.end() - kept);
    scan.points.erase(kept, scan.points.end());
  }
  return removed;
}

}  // namespace mlic
