#include "mlic_core/solver/accumulator.h"

namespace mlic {

Accumulator::Accumulator(int knots, int bandwidth, int calibration, int first_knot)
    : first_knot(first_knot),
      band(Eigen::MatrixXd::Zero(bandwidth + 1, knots)),
      border(Eigen::MatrixXd::Zero(calibration, knots)),
      corner(Eigen::MatrixXd::Zero(calibration, calibration)),
      gradient_knots(Eigen::VectorXd::Zero(knots)),
      gradient_calibration(Eigen::VectorXd::Zero(calibration)) {}

Accumulator& Accumulator::operator+=(const Accumulator& other) {
  const Eigen::Index at = Local(other.first_knot), count = other.band.cols();
  band.middleCols(at, count) += other.band;
  border.middleCols(at, count) += other.border;
  corner += other.corner;
  gradient_knots.segment(at, count) += other.gradient_knots;
  gradient_calibration += other.gradient_calibration;
  cost += other.cost;
  return *this;
}

}  // namespace mlic
