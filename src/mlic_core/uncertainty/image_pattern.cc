#include "mlic_core/uncertainty/image_pattern.h"

#include <algorithm>
#include <cmath>

namespace mlic {

void ImagePattern::Add(std::size_t part, const Eigen::Vector2d& errors, double weight) {
  Part& sums = parts_[part];
  sums.errors += errors;
  sums.errors_by_weight += weight * errors;
  sums.weight += weight;
  sums.squared_errors += errors.squaredNorm();
  sums.squared_weights += weight * weight;
}

void ImagePattern::Add(const ImagePattern& other) {
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    parts_[p].errors += other.parts_[p].errors;
    parts_[p].errors_by_weight += other.parts_[p].errors_by_weight;
    parts_[p].weight += other.parts_[p].weight;
    parts_[p].squared_errors += other.parts_[p].squared_errors;
    parts_[p].squared_weights += other.parts_[p].squared_weights;
  }
}

double ImagePattern::Rms() const {
  double squares = 0.0, weights = 0.0, variance = 0.0;
  for (const Part& part : parts_) {
    if (!(part.weight > 0.0)) continue;
    const Eigen::Vector2d mean = part.errors / part.weight;
    // Of the mean, by the scatter of landmarks about it.
    const double noise = (part.squared_errors - 2.0 * mean.dot(part.errors_by_weight) +
                          mean.squaredNorm() * part.squared_weights) /
                         (part.weight * part.weight);
    squares += part.weight * (mean.squaredNorm() - noise);
    weights += part.weight;
    // A squared mean of two coordinates that is noise alone scatters by as much as it is in the mean.
    variance += std::pow(part.weight * noise, 2);
  }
  if (!(weights > 0.0)) return 0.0;
  return std::sqrt((std::max(0.0, squares) + std::sqrt(std::max(0.0, variance))) / weights);
}

}  // namespace mlic
