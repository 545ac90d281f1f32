#pragma once

#include <Eigen/Core>
#include <vector>

namespace mlic {

// A symmetric positive definite matrix whose columns end early, with a border of full rows below, and its
// Cholesky factor in the same place:
//
//   [ A  B^T ]    A = L L^T,  border becomes B L^-T, so that the Schur complement on what the border belongs
//   [ B   C  ]    to is C - border border^T.
//
// Column j of A holds nothing below row reach(j), and neither does that of L: an ordering by time keeps the
// cost at size * reach^2. Stored as columns of tiles, each as tall as its reach. All sums run in an order of
// their own, whatever the number of threads. docs/method.md, section 6.
class EnvelopeMatrix {
 public:
  // reach: last row of each column that may differ from zero, at least the column itself; made monotonous
  // here. border_rows: rows of the border. All zero.
  EnvelopeMatrix(std::vector<int> reach, int border_rows);

  int size() const { return size_; }

  // Element i of this is row FirstRow(column) + i of the column, down to its reach. What lies above the
  // diagonal is ignored.
  double* Column(int column) {
    const Panel& panel = panels_[column / kTile];
    return values_.data() + panel.begin + static_cast<std::size_t>(column % kTile) * panel.height;
  }
  static int FirstRow(int column) { return column - column % kTile; }

  // Tiles of kTile rows and columns, fewer in the last. Tile (row, column), for rows from the column on to
  // LastTile(column), is Width(row) x Width(column), its columns Stride(column) apart.
  static constexpr int kTile = 96;  // from: structural, speed only
  int Tiles() const { return static_cast<int>(panels_.size()); }
  int LastTile(int column) const { return panels_[column].last_tile; }
  int Width(int tile) const { return panels_[tile].width; }
  int Stride(int column) const { return panels_[column].height; }
  double* Tile(int row, int column) {
    return values_.data() + panels_[column].begin + static_cast<std::size_t>(row - column) * kTile;
  }

  Eigen::MatrixXd border;  // border_rows x size

  // Factors A in place and divides the border by it. False if A is not positive definite.
  bool Factor();

  // Solves L^T x = right in place, once factored.
  void SolveTransposed(Eigen::VectorXd* right) const;
  // The same of each row (any number x size), reading the factor once for many of them.
  void SolveTransposedRows(Eigen::MatrixXd* rows) const;

 private:
  struct Panel {
    std::size_t begin;  // in values_
    int height;
    int width;
    int last_tile;
  };

  void DivideBelow(std::size_t k);
  void UpdateTile(std::size_t k, std::size_t tile);

  int size_;
  std::vector<Panel> panels_;
  std::vector<double> values_;
};

}  // namespace mlic
