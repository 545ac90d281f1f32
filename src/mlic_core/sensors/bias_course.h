#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <vector>

namespace mlic {

// Biases of gyroscope (rad/s) and accelerometer (m/s^2) in the course of a drive: between knots on a straight
// line, before the first and after the last as there. One knot: constant.
struct BiasCourse {
  using Bias = Eigen::Matrix<double, 6, 1>;  // gyroscope, accelerometer

  double start = 0.0;    // s, of the first knot
  double spacing = 1.0;  // s
  std::vector<Bias> knots{Bias::Zero()};

  BiasCourse() = default;
  BiasCourse(const Eigen::Vector3d& gyroscope, const Eigen::Vector3d& accelerometer) {
    knots[0] << gyroscope, accelerometer;
  }

  bool IsConstant() const { return knots.size() == 1; }

  // Between `knot` and the one behind it, `share` of the way.
  struct Place {
    int knot;
    double share;
  };
  Place At(double time) const {
    if (IsConstant()) return {0, 0.0};
    const double at = std::clamp((time - start) / spacing, 0.0, static_cast<double>(knots.size() - 1));
    const int knot = std::min(static_cast<int>(at), static_cast<int>(knots.size()) - 2);
    return {knot, at - knot};
  }
  Bias Value(double time) const {
    if (IsConstant()) return knots[0];
    const Place place = At(time);
    return (1.0 - place.share) * knots[place.knot] + place.share * knots[place.knot + 1];
  }
  Bias Mean() const {
    Bias sum = Bias::Zero();
    for (const Bias& knot : knots) sum += knot;
    return sum / static_cast<double>(knots.size());
  }
  // The largest difference between two knots: of the gyroscope's, of the accelerometer's.
  Eigen::Vector2d Range() const {
    Eigen::Vector2d range = Eigen::Vector2d::Zero();
    for (const Bias& a : knots) {
      for (const Bias& b : knots) {
        const Bias step = a - b;
        range = range.cwiseMax(Eigen::Vector2d(step.head<3>().norm(), step.tail<3>().norm()));
      }
    }
    return range;
  }
};

// Standard deviations of the step from one knot to the next.
struct BiasSteps {
  double gyroscope = 0.0;      // rad/s
  double accelerometer = 0.0;  // m/s^2
};

}  // namespace mlic
