#include "mlic_core/lidar/plane_cells.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "mlic_core/common/order_statistics.h"
#include "mlic_core/common/random.h"
#include "mlic_core/geometry/symmetric_matrix.h"

namespace mlic {
namespace {

// Points or cells side by side that are off a plane.
constexpr int kFewestOff = 2;  // from: derivation, one may be an outlier of its own
constexpr double kOnIt = 2.5;  // sigmas from a plane of cells that lie on it; from: Rousseeuw and Leroy, 1987

// Square cells over points in a plane.
class CellGrid {
 public:
  // Cells are at least this wide, m, and hold at least so many points in the mean.
  CellGrid(const std::vector<PointAtPlane>& points, double width, double points_per_cell) {
    Eigen::Vector2d last = points.front().position;
    first_ = last;
    for (const PointAtPlane& p : points) {
      first_ = first_.cwiseMin(p.position);
      last = last.cwiseMax(p.position);
    }
    const double area = (last - first_).prod();
    width_ = std::max(width, std::sqrt(points_per_cell * area / static_cast<double>(points.size())));
    columns_ = ColumnAndRow(last)[0] + 1;
    rows_ = ColumnAndRow(last)[1] + 1;
  }

  std::size_t Size() const { return static_cast<std::size_t>(columns_) * rows_; }

  // position: of one of the points.
  std::size_t CellOf(const Eigen::Vector2d& position) const {
    const Eigen::Vector2i cell = ColumnAndRow(position);
    return CellAt(cell[0], cell[1]);
  }

  // Calls visit(cell) for the cell and those beside it.
  template <typename Visit>
  void ForEachAround(std::size_t cell, const Visit& visit) const {
    const int column = static_cast<int>(cell % columns_), row = static_cast<int>(cell / columns_);
    for (int r = std::max(0, row - 1); r <= std::min(rows_ - 1, row + 1); ++r) {
      for (int c = std::max(0, column - 1); c <= std::min(columns_ - 1, column + 1); ++c) visit(CellAt(c, r));
    }
  }

  // Whether the cells of points are among these.
  std::vector<bool> Among(const std::vector<bool>& cells, const std::vector<PointAtPlane>& points) const {
    std::vector<bool> among(points.size());
    for (std::size_t k = 0; k < points.size(); ++k) among[k] = cells[CellOf(points[k].position)];
    return among;
  }

 private:
  Eigen::Vector2i ColumnAndRow(const Eigen::Vector2d& position) const {
    return ((position - first_) / width_).cast<int>();
  }
  std::size_t CellAt(int column, int row) const { return static_cast<std::size_t>(row) * columns_ + column; }

  double width_;
  Eigen::Vector2d first_;
  int columns_, rows_;
};

// The points of a cell together.
struct CellMean {
  int count = 0;
  double information = 0.0;                            // of the distance, 1 / m^2
  double distance = 0.0;                               // m
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  // m

  // Of a plane: slopes along both axes and the distance at the origin.
  Eigen::Vector3d Row() const { return {position.x(), position.y(), 1.0}; }
  double Off(const Eigen::Vector3d& plane) const { return distance - Row().dot(plane); }
};

std::vector<CellMean> MeansOfCells(const CellGrid& grid, const std::vector<PointAtPlane>& points) {
  std::vector<CellMean> cells(grid.Size());
  for (const PointAtPlane& p : points) {
    CellMean& cell = cells[grid.CellOf(p.position)];
    const double information = 1.0 / (p.sigma * p.sigma);
    ++cell.count;
    cell.information += information;
    cell.distance += information * p.distance;
    cell.position += information * p.position;
  }
  for (CellMean& cell : cells) {
    if (cell.count == 0) continue;
    cell.distance /= cell.information;
    cell.position /= cell.information;
  }
  return cells;
}

double MedianSquare(const std::vector<CellMean>& cells, const Eigen::Vector3d& plane) {
  std::vector<double> squares;
  squares.reserve(cells.size());
  for (const CellMean& cell : cells) squares.push_back(std::pow(cell.Off(plane), 2));
  return Median(std::move(squares));
}

// The variance of cells about a plane beyond what their points' noise makes, m^2.
double VarianceBetween(const std::vector<CellMean>& cells, const Eigen::Vector3d& plane) {
  constexpr double kOfMedian = 2.198;  // from: derivation, variance of a normal distribution
  std::vector<double> excess;
  excess.reserve(cells.size());
  for (const CellMean& cell : cells) {
    excess.push_back(kOfMedian * std::pow(cell.Off(plane), 2) - 1.0 / cell.information);
  }
  return std::max(0.0, Median(std::move(excess)));
}

// The plane that most of the cells share: of the least median of squares among those through three cells
// drawn at random, then fitted to the cells that lie on it.
Eigen::Vector3d PlaneOfMost(const std::vector<CellMean>& cells) {
  constexpr int kDraws = 40;  // from: derivation, with 4 of 10 cells off it is missed once in 10 000 times
  Random random(1);
  Eigen::Vector3d plane = Eigen::Vector3d::Zero();
  double least = MedianSquare(cells, plane);
  for (int draw = 0; draw < kDraws; ++draw) {
    Eigen::Matrix3d rows;
    Eigen::Vector3d distances;
    for (int k = 0; k < 3; ++k) {
      const CellMean& cell = cells[random.Next() % cells.size()];
      rows.row(k) = cell.Row();
      distances[k] = cell.distance;
    }
    const Eigen::Vector3d through = rows.inverse() * distances;
    if (!through.allFinite()) continue;  // the same cell twice, or three in a line
    const double median = MedianSquare(cells, through);
    if (median < least) {
      least = median;
      plane = through;
    }
  }
  for (int round = 0; round < 3; ++round) {
    const double between = VarianceBetween(cells, plane);
    Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
    Eigen::Vector3d g = Eigen::Vector3d::Zero();
    for (const CellMean& cell : cells) {
      const double variance = 1.0 / cell.information + between;
      if (std::pow(cell.Off(plane), 2) > kOnIt * kOnIt * variance) continue;
      H += cell.Row() * cell.Row().transpose() / variance;
      g += cell.Row() * cell.distance / variance;
    }
    plane = SolveSymmetric3(H, g);
  }
  return plane;
}

}  // namespace

std::vector<bool> FindMixed(const std::vector<PointAtPlane>& points, double gate_sigmas, double gate) {
  // from: measured, trials, LiDAR, open 54, 106 and its world with seed 3: 0.02 changes results by at most
  // 0.4 sigma
  constexpr double kShareOff = 0.05;
  struct Count {
    int all = 0, off = 0;
  };
  if (points.empty()) return {};
  const CellGrid grid(points, gate, 1.0);
  std::vector<Count> counts(grid.Size());
  for (const PointAtPlane& p : points) {
    Count& count = counts[grid.CellOf(p.position)];
    ++count.all;
    count.off += std::abs(p.distance) > gate_sigmas * p.sigma ? 1 : 0;
  }
  std::vector<bool> mixed(grid.Size(), false);
  for (std::size_t cell = 0; cell < mixed.size(); ++cell) {
    Count around;
    grid.ForEachAround(cell, [&](std::size_t other) {
      around.all += counts[other].all;
      around.off += counts[other].off;
    });
    mixed[cell] = around.off >= kFewestOff && around.off > kShareOff * around.all;
  }
  return grid.Among(mixed, points);
}

std::vector<bool> FindRelief(const std::vector<PointAtPlane>& points, double gate) {
  constexpr double kPointsPerCell = 8.0;   // from: measured, trials, LiDAR, open 551: 5 finds as much
  constexpr int kFewestPoints = 3;         // of a cell that counts; from: guard
  constexpr std::size_t kFewestCells = 8;  // from: guard, fewer tell no plane
  std::vector<bool> relief(points.size(), false);
  if (points.empty()) return relief;
  const CellGrid grid(points, 0.5 * gate, kPointsPerCell);
  const std::vector<CellMean> cells = MeansOfCells(grid, points);
  std::vector<CellMean> full;
  for (const CellMean& cell : cells) {
    if (cell.count >= kFewestPoints) full.push_back(cell);
  }
  if (full.size() < kFewestCells) return relief;
  const Eigen::Vector3d plane = PlaneOfMost(full);
  const double between = VarianceBetween(full, plane);
  std::vector<int> side(cells.size(), 0);  // of the plane, 0 for what lies on it
  for (std::size_t k = 0; k < cells.size(); ++k) {
    const double off = cells[k].Off(plane), variance = 1.0 / cells[k].information + between;
    if (cells[k].count < kFewestPoints || off * off <= kOnIt * kOnIt * variance) continue;
    side[k] = off > 0.0 ? 1 : -1;
  }
  std::vector<bool> in_relief(cells.size(), false);
  for (std::size_t k = 0; k < cells.size(); ++k) {
    if (side[k] == 0) continue;
    int count = 0;
    grid.ForEachAround(k, [&](std::size_t around) { count += side[around] == side[k] ? 1 : 0; });
    if (count < kFewestOff) continue;
    grid.ForEachAround(k, [&](std::size_t around) { in_relief[around] = true; });
  }
  return grid.Among(in_relief, points);
}

}  // namespace mlic
