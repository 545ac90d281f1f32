#pragma once

#include <Eigen/Core>
#include <Eigen/Eigenvalues>

namespace mlic {

// The plane normal . x = offset, with a unit normal.
struct Plane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double offset = 0.0;

  double SignedDistance(const Eigen::Vector3d& p) const { return normal.dot(p) - offset; }
};

// Moments of a set of points about a fixed anchor: count, sum and sum of outer products. The anchor keeps the
// differences small, so that coordinates of kilometres do not cost digits.
struct PointCluster {
  double count = 0.0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d outer = Eigen::Matrix3d::Zero();

  void Add(const Eigen::Vector3d& p_from_anchor) {
    count += 1.0;
    sum += p_from_anchor;
    outer += p_from_anchor * p_from_anchor.transpose();
  }
  void Add(const PointCluster& other) {
    count += other.count;
    sum += other.sum;
    outer += other.outer;
  }
  Eigen::Vector3d Mean() const { return sum / count; }
  Eigen::Matrix3d Covariance() const {
    const Eigen::Vector3d mean = Mean();
    return outer / count - mean * mean.transpose();
  }
};

}  // namespace mlic
