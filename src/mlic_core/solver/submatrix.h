#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace mlic {

// The rows with these indices.
inline Eigen::MatrixXd SelectRows(const Eigen::MatrixXd& given, const std::vector<int>& kept) {
  Eigen::MatrixXd rows(static_cast<Eigen::Index>(kept.size()), given.cols());
  for (std::size_t i = 0; i < kept.size(); ++i) rows.row(static_cast<Eigen::Index>(i)) = given.row(kept[i]);
  return rows;
}

// The rows and columns with these indices.
inline Eigen::MatrixXd Submatrix(const Eigen::MatrixXd& given, const std::vector<int>& rows,
                                 const std::vector<int>& columns) {
  return SelectRows(SelectRows(given, rows).transpose(), columns).transpose();
}
inline Eigen::MatrixXd Submatrix(const Eigen::MatrixXd& given, const std::vector<int>& kept) {
  return Submatrix(given, kept, kept);
}

}  // namespace mlic
