#pragma once

#include <Eigen/Core>

namespace mlic {

// Uniform cubic (order 4) B-spline in cumulative form. Segment i is governed by the control points i .. i+3;
// control point j has its greatest weight at time start + (j - 1) * spacing. Matrix form: Sommer et al.,
// "Efficient derivative computation for cumulative B-splines on Lie groups", CVPR 2020.
struct UniformKnots {
  double start = 0.0;    // s, where the span begins
  double spacing = 0.1;  // s
  int count = 4;         // control points

  // Knots whose span covers [start, end].
  static UniformKnots Covering(double start, double end, double spacing);

  int Segments() const { return count - 3; }
  double End() const { return start + Segments() * spacing; }
  bool Contains(double time) const { return time >= start && time <= End(); }
  double ControlPointTime(int j) const { return start + (j - 1) * spacing; }
};

// Basis at one time: first control point of the segment, and for its 4 control points the cumulative
// coefficients lambda_j (lambda_0 = 1) with their first and second time derivatives (1/s, 1/s^2).
struct SplineBasis {
  int first = 0;
  Eigen::Vector4d lambda;
  Eigen::Vector4d lambda_dot;
  Eigen::Vector4d lambda_ddot;

  // Times outside the span use the polynomial of the nearest segment.
  SplineBasis(const UniformKnots& knots, double time);

  // The ordinary (not cumulative) coefficients: p = sum_j weight_j * p_j.
  static Eigen::Vector4d Weights(const Eigen::Vector4d& cumulative) {
    return {cumulative[0] - cumulative[1], cumulative[1] - cumulative[2], cumulative[2] - cumulative[3],
            cumulative[3]};
  }
};

}  // namespace mlic
