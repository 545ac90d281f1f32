#include "mlic_core/imu/rotation_fit.h"

#include <algorithm>
#include <limits>

#include "mlic_core/common/order_statistics.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/imu/robust.h"

namespace mlic {

Eigen::Quaterniond RobustMean(const std::vector<Eigen::Quaterniond>& rotations, double sigma) {
  Eigen::Quaterniond mean = rotations.front();
  double least = std::numeric_limits<double>::infinity();
  std::vector<double> distances(rotations.size());
  for (const Eigen::Quaterniond& candidate : rotations) {
    for (std::size_t i = 0; i < rotations.size(); ++i) distances[i] = AngleBetween(candidate, rotations[i]);
    const double median = Median(distances);
    if (median >= least) continue;
    least = median;
    mean = candidate;
  }
  for (int iteration = 0; iteration < 4; ++iteration) {
    std::vector<Eigen::Vector3d> differences;
    for (std::size_t i = 0; i < rotations.size(); ++i) {
      differences.push_back(Log(Eigen::Quaterniond(mean.conjugate() * rotations[i])));
      distances[i] = differences.back().norm();
    }
    const double scale = std::max(sigma, SigmaFromNorms(distances));
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double weights = 0.0;
    for (std::size_t i = 0; i < rotations.size(); ++i) {
      const double weight = TukeyWeight(distances[i], scale);
      sum += weight * differences[i];
      weights += weight;
    }
    if (weights <= 0.0) break;
    mean = (mean * ExpQuaternion(sum / weights)).normalized();
  }
  return mean;
}

}  // namespace mlic
