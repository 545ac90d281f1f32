#include "mlic_core/crossmodal/three_point.h"

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "mlic_core/geometry/symmetric_matrix.h"

namespace mlic {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int kPairs[3][2] = {{0, 1}, {0, 2}, {1, 2}};  // from: structural

// |l_i b_i - l_j b_j|^2 = l.M.l for pair k.
Matrix3d SquaredDistance(const Vector3d (&bearings)[3], int k) {
  const int i = kPairs[k][0], j = kPairs[k][1];
  Matrix3d M = Matrix3d::Zero();
  M(i, i) = M(j, j) = 1.0;
  M(i, j) = M(j, i) = -bearings[i].dot(bearings[j]);
  return M;
}

Matrix3d Adjugate(const Matrix3d& A) {
  Matrix3d out;
  for (int i = 0; i < 3; ++i) out.row(i) = A.col((i + 1) % 3).cross(A.col((i + 2) % 3)).transpose();
  return out;
}

// A real root of c0 + c1 x + c2 x^2 + x^3: safe bisection to a bracket, then Newton.
double RealRoot(double c0, double c1, double c2) {
  const auto value = [&](double x) { return c0 + x * (c1 + x * (c2 + x)); };
  const double bound = 1.0 + std::max({std::abs(c0), std::abs(c1), std::abs(c2)});  // Cauchy's
  double low = -bound, high = bound;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (value(middle) < 0.0 ? low : high) = middle;
  }
  double x = 0.5 * (low + high);
  for (int i = 0; i < 3; ++i) {
    const double slope = c1 + x * (2.0 * c2 + 3.0 * x);
    if (std::abs(slope) > 1e-12) x -= value(x) / slope;
  }
  return x;
}

// Newton's method on the three distances.
Vector3d Polish(const Matrix3d (&M)[3], const Vector3d& squared, Vector3d l) {
  for (int i = 0; i < 3; ++i) {
    Vector3d residual;
    Matrix3d J;
    for (int k = 0; k < 3; ++k) {
      residual[k] = l.dot(M[k] * l) - squared[k];
      J.row(k) = 2.0 * (M[k] * l).transpose();
    }
    const Vector3d step = J.partialPivLu().solve(residual);
    if (!step.allFinite()) break;
    l -= step;
  }
  return l;
}

// Axes from three points: along the first edge, and the triangle's normal.
Matrix3d Axes(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  Matrix3d axes;
  axes.col(0) = (b - a).normalized();
  axes.col(2) = (b - a).cross(c - a).normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  return axes;
}

}  // namespace

int SolveThreePoint(const Vector3d (&bearings)[3], const Vector3d (&points)[3],
                    RigidTransform (&poses)[kMostThreePointPoses]) {
  Matrix3d M[3];
  Vector3d squared;
  for (int k = 0; k < 3; ++k) {
    M[k] = SquaredDistance(bearings, k);
    squared[k] = (points[kPairs[k][0]] - points[kPairs[k][1]]).squaredNorm();
  }
  const double scale = squared.maxCoeff();
  if (!(scale > 0.0) || (points[1] - points[0]).cross(points[2] - points[0]).norm() < 1e-9 * scale) return 0;
  squared /= scale;
  const Matrix3d D1 = squared[2] * M[0] - squared[0] * M[2];
  const Matrix3d D2 = squared[2] * M[1] - squared[1] * M[2];
  const double c3 = D2.determinant();
  if (std::abs(c3) < 1e-14) return 0;
  const double gamma =
      RealRoot(D1.determinant() / c3, (Adjugate(D1) * D2).trace() / c3, (Adjugate(D2) * D1).trace() / c3);
  const SymmetricEigen<3> singular(D1 + gamma * D2);
  // Eigenvalues ascend: the singular one is in the middle where the others' signs differ.
  const Vector3d& sigma = singular.eigenvalues();
  if (!(sigma[0] < 0.0) || !(sigma[2] > 0.0)) return 0;
  const double ratio = std::sqrt(-sigma[0] / sigma[2]);
  const Matrix3d sum = M[0] + M[1] + M[2];
  int count = 0;
  for (const double sign : {-1.0, 1.0}) {
    const Vector3d normal =
        (singular.eigenvectors().col(2) + sign * ratio * singular.eigenvectors().col(0)).normalized();
    const Vector3d p = normal.unitOrthogonal(), q = normal.cross(p);
    // On the plane l = x p + y q, a x^2 + 2 b x y + c y^2 = 0.
    const Matrix3d& D = D1.norm() > D2.norm() ? D1 : D2;
    const double a = p.dot(D * p), b = p.dot(D * q), c = q.dot(D * q);
    const double discriminant = b * b - a * c;
    if (discriminant < 0.0) continue;
    const double root = std::sqrt(discriminant);
    for (const double way : {-1.0, 1.0}) {
      const double x = -b + way * root;
      Vector3d l = std::abs(a) > std::abs(c) ? Vector3d(x * p + a * q) : Vector3d(c * p + x * q);
      const double norm = l.dot(sum * l);
      if (!(norm > 0.0)) continue;
      l *= std::sqrt(squared.sum() / norm) * (l.sum() > 0.0 ? 1.0 : -1.0);
      if (l.minCoeff() <= 0.0 || count == kMostThreePointPoses) continue;
      l = Polish(M, squared, l) * std::sqrt(scale);
      if (!l.allFinite() || l.minCoeff() <= 0.0) continue;
      const Vector3d seen[3] = {l[0] * bearings[0], l[1] * bearings[1], l[2] * bearings[2]};
      const Matrix3d R = Axes(seen[0], seen[1], seen[2]) * Axes(points[0], points[1], points[2]).transpose();
      poses[count].rotation = Eigen::Quaterniond(R).normalized();
      poses[count].translation = seen[0] - R * points[0];
      ++count;
    }
  }
  return count;
}

}  // namespace mlic
