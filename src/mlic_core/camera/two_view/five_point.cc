#include "mlic_core/camera/two_view/five_point.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <cmath>

namespace mlic {
namespace {

// Polynomials in x, y, z up to degree 3 by their coefficients of
//   xxx xxy xxz xyy xyz xzz yyy yyz yzz zzz  xx xy xz yy yz zz  x y z 1.
constexpr int kMonomials = 20, kQuadratic = 10, kLinear = 16;  // from: structural
using Polynomial = Eigen::Matrix<double, kMonomials, 1>;

// Where the product of two monomials stands; -1 beyond degree 3.
struct ProductTable {
  int index[kMonomials][kMonomials];

  ProductTable() {
    const int exponents[kMonomials][3] = {{3, 0, 0}, {2, 1, 0}, {2, 0, 1}, {1, 2, 0}, {1, 1, 1},
                                          {1, 0, 2}, {0, 3, 0}, {0, 2, 1}, {0, 1, 2}, {0, 0, 3},
                                          {2, 0, 0}, {1, 1, 0}, {1, 0, 1}, {0, 2, 0}, {0, 1, 1},
                                          {0, 0, 2}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}};
    for (int a = 0; a < kMonomials; ++a) {
      for (int b = 0; b < kMonomials; ++b) {
        index[a][b] = -1;
        for (int c = 0; c < kMonomials; ++c) {
          bool same = true;
          for (int i = 0; i < 3; ++i) same = same && exponents[a][i] + exponents[b][i] == exponents[c][i];
          if (same) index[a][b] = c;
        }
      }
    }
  }
};

// sum += factor * a * b, for a with monomials from first_a on and b linear.
void AddProduct(const Polynomial& a, int first_a, const Polynomial& b, double factor, Polynomial* sum) {
  static const ProductTable table;
  for (int i = first_a; i < kMonomials; ++i) {
    for (int j = kLinear; j < kMonomials; ++j) (*sum)[table.index[i][j]] += factor * a[i] * b[j];
  }
}

// The rows: det E = 0, and (E E^T - trace(E E^T) / 2) E = 0.
Eigen::Matrix<double, 10, kMonomials> Constraints(const Polynomial (&E)[3][3]) {
  Eigen::Matrix<double, 10, kMonomials> rows;
  Polynomial determinant = Polynomial::Zero();
  for (int c = 0; c < 3; ++c) {
    const int c1 = (c + 1) % 3, c2 = (c + 2) % 3;
    Polynomial minor = Polynomial::Zero();
    AddProduct(E[1][c1], kLinear, E[2][c2], 1.0, &minor);
    AddProduct(E[1][c2], kLinear, E[2][c1], -1.0, &minor);
    AddProduct(minor, kQuadratic, E[0][c], 1.0, &determinant);
  }
  rows.row(0) = determinant;
  Polynomial square[3][3];
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) {
      square[i][j].setZero();
      for (int k = 0; k < 3; ++k) AddProduct(E[i][k], kLinear, E[j][k], 1.0, &square[i][j]);
      square[j][i] = square[i][j];
    }
  }
  const Polynomial half_trace = 0.5 * (square[0][0] + square[1][1] + square[2][2]);
  for (int i = 0; i < 3; ++i) square[i][i] -= half_trace;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      Polynomial sum = Polynomial::Zero();
      for (int k = 0; k < 3; ++k) AddProduct(square[i][k], kQuadratic, E[k][j], 1.0, &sum);
      rows.row(1 + 3 * i + j) = sum;
    }
  }
  return rows;
}

}  // namespace

int SolveFivePoint(const Eigen::Vector3d (&bearings_a)[5], const Eigen::Vector3d (&bearings_b)[5],
                   Eigen::Matrix3d (&solutions)[kMostEssentialMatrices]) {
  Eigen::Matrix<double, 9, 5> epipolar;  // columns: b a^T, row by row
  for (int i = 0; i < 5; ++i) {
    for (int r = 0; r < 3; ++r) epipolar.block<3, 1>(3 * r, i) = bearings_b[i][r] * bearings_a[i];
  }
  const Eigen::HouseholderQR<Eigen::Matrix<double, 9, 5>> qr(epipolar);
  const Eigen::Matrix<double, 9, 9> Q = qr.householderQ() * Eigen::Matrix<double, 9, 9>::Identity();
  Polynomial E[3][3];
  for (int k = 0; k < 9; ++k) {
    E[k / 3][k % 3].setZero();
    for (int i = 0; i < 4; ++i) E[k / 3][k % 3][kLinear + i] = Q(k, 5 + i);
  }
  const Eigen::Matrix<double, 10, kMonomials> rows = Constraints(E);
  const Eigen::Matrix<double, 10, 10> cubic =
      Eigen::PartialPivLU<Eigen::Matrix<double, 10, 10>>(rows.leftCols<10>()).solve(rows.rightCols<10>());
  if (!cubic.allFinite()) return 0;
  // Multiplication by x in the basis xx xy xz yy yz zz x y z 1 of the quotient ring.
  Eigen::Matrix<double, 10, 10> action = Eigen::Matrix<double, 10, 10>::Zero();
  action.topRows<6>() = -cubic.topRows<6>();
  action(6, 0) = action(7, 1) = action(8, 2) = action(9, 6) = 1.0;
  const Eigen::EigenSolver<Eigen::Matrix<double, 10, 10>> eigen(action);
  if (eigen.info() != Eigen::Success) return 0;
  int count = 0;
  const auto vectors = eigen.eigenvectors();
  for (int s = 0; s < 10; ++s) {
    if (eigen.eigenvalues()[s].imag() != 0.0) continue;
    const Eigen::Matrix<double, 10, 1> v = vectors.col(s).real();
    if (std::abs(v[9]) < 1e-12) continue;
    const Eigen::Matrix<double, 9, 1> e =
        (Q.col(5) * v[6] + Q.col(6) * v[7] + Q.col(7) * v[8]) / v[9] + Q.col(8);
    Eigen::Matrix3d& solution = solutions[count];
    solution << e[0], e[1], e[2], e[3], e[4], e[5], e[6], e[7], e[8];
    const double norm = solution.norm();
    if (!std::isfinite(norm) || norm == 0.0) continue;
    solution *= std::sqrt(2.0) / norm;
    ++count;
  }
  return count;
}

}  // namespace mlic
