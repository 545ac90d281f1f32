#pragma once

#include <Eigen/Core>
#include <algorithm>

#include "mlic_core/geometry/so3.h"
#include "mlic_core/sensors/measurements.h"
#include "mlic_core/sensors/rig.h"
#include "mlic_core/trajectory/split_spline.h"

namespace mlic {

// Where the splines are read for one sample: rates at its time, the specific force earlier by the lag of the
// accelerometer. Each in the segment that it falls into.
struct ImuBases {
  SplineBasis rates;               // rotation
  SplineBasis rotation, position;  // of the specific force

  // time: of the sample, s.
  ImuBases(const SplitSpline& trajectory, double time, double lag)
      : rates(trajectory.rotation.knots(), time),
        rotation(trajectory.rotation.knots(), time - lag),
        position(trajectory.position.knots(), time - lag) {}
  ImuBases(const SplineBasis& rates, const SplineBasis& rotation, const SplineBasis& position)
      : rates(rates), rotation(rotation), position(position) {}
};

// The IMU residuals (docs/method.md, section 3.1) of one sample, not whitened, with Jacobians:
//   r_w = M_w w(t) + b_w - w_m,   r_a = M_a f(t - lag) + b_a - a_m,   f = R^T (p'' - g)
// Columns: 4 rotation control points (12; of r_w those of ImuBases::rates, of r_a those of
// ImuBases::rotation), 4 position control points (12), gyroscope bias (3), accelerometer bias (3), gravity's
// magnitude (1), lag of the accelerometer (1), rotation of the accelerometer to the gyroscope (of r_a
// M_a <- Exp(delta) M_a, of r_w M_w <- M_w Exp(-delta): TurnOne, 3), scale and shear of the accelerometer
// (M_a <- M_a (I + delta), delta a lower triangle row by row, 6) and of the gyroscope (M_w <- (I + delta)
// M_w, 6).
//
// The column of the lag has the jerk's mean about t - lag in place of the jerk. That of a cubic spline is a
// step function. Its steps are noise and what the spline cannot follow; no control point follows them, and
// where samples lie otherwise before the knots than behind they agree with the residuals (docs/method.md).
struct ImuResidual {
  static constexpr int kPosition = 12;                  // from: structural, places of columns
  static constexpr int kBias = 24;                      // from: structural, places of columns
  static constexpr int kGravity = 30;                   // from: structural, places of columns
  static constexpr int kLag = 31;                       // from: structural, places of columns
  static constexpr int kAlignment = 32;                 // from: structural, places of columns
  static constexpr int kMatrices = 35;                  // from: structural, places of columns
  static constexpr int kColumns = 47;                   // from: structural, places of columns
  using Jacobian = Eigen::Matrix<double, kColumns, 6>;  // one column for each residual component

  // Leaves of the rotation's columns those of the gyroscope about the directions of a projector, about which
  // the IMU's axes are the accelerometer's, and those of the accelerometer about others.
  static void TurnOne(const Eigen::Matrix3d& accelerometer_axes, Jacobian* jacobian) {
    auto rows = jacobian->middleRows<3>(kAlignment);
    rows.leftCols<3>() = Eigen::Matrix3d(accelerometer_axes * rows.leftCols<3>());
    rows.rightCols<3>() -= Eigen::Matrix3d(accelerometer_axes * rows.rightCols<3>());
  }

  // gravity: map frame, m/s^2. Rows 0-2 of the result: rad/s, 3-5: m/s^2. jacobian may be null.
  static Eigen::Matrix<double, 6, 1> Evaluate(const SplitSpline& trajectory, const ImuBases& bases,
                                              const ImuCalibration& imu, const Eigen::Vector3d& gravity,
                                              const ImuSample& sample, Jacobian* jacobian) {
    So3Spline::Jacobians J;
    So3Spline::Value value = jacobian != nullptr ? trajectory.rotation.Evaluate(bases.rates, true, &J)
                                                 : trajectory.rotation.Evaluate(bases.rates);
    Eigen::Matrix<double, 6, 1> residual;
    residual.head<3>() =
        imu.gyroscope_matrix * value.angular_velocity + imu.gyroscope_bias - sample.angular_velocity;
    if (jacobian != nullptr) FillGyroscope(imu, value, J, jacobian);
    if (imu.accelerometer_lag != 0.0) {
      value = jacobian != nullptr ? trajectory.rotation.Evaluate(bases.rotation, false, &J)
                                  : trajectory.rotation.Evaluate(bases.rotation);
    }
    const Eigen::Vector3d force =
        value.rotation.transpose() * (trajectory.position.Acceleration(bases.position) - gravity);
    residual.tail<3>() = imu.accelerometer_matrix * force + imu.accelerometer_bias - sample.specific_force;
    if (jacobian == nullptr) return residual;
    const Eigen::Matrix3d force_to_position = imu.accelerometer_matrix * value.rotation.transpose();
    const Eigen::Matrix3d force_to_rotation = imu.accelerometer_matrix * Hat(force);
    const Eigen::Vector4d weights = SplineBasis::Weights(bases.position.lambda_ddot);
    for (int j = 0; j < 4; ++j) {
      jacobian->block<3, 3>(3 * j, 3) = (force_to_rotation * J.rotation[j]).transpose();
      jacobian->block<3, 3>(kPosition + 3 * j, 3) = weights[j] * force_to_position.transpose();
    }
    jacobian->block<3, 3>(kBias + 3, 3).setIdentity();
    // g = |g| * down, and the map's axes are aligned to it.
    jacobian->block<1, 3>(kGravity, 3) = -(force_to_position * gravity.normalized()).transpose();
    const Eigen::Vector3d jerk = MeanJerk(trajectory.position, sample.time - imu.accelerometer_lag);
    jacobian->block<1, 3>(kLag, 3) =
        (force_to_rotation * -value.angular_velocity - force_to_position * jerk).transpose();
    jacobian->block<3, 3>(kAlignment, 3) = Hat(imu.accelerometer_matrix * force);  // (-Hat)^T
    int lower = kMatrices;
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c <= r; ++c) {
        jacobian->block<1, 3>(lower++, 3) = force[c] * imu.accelerometer_matrix.col(r).transpose();
      }
    }
    return residual;
  }

 private:
  // About a time, over kLeastSpan or one knot spacing, whichever is longer, as far as the spline goes.
  static Eigen::Vector3d MeanJerk(const PositionSpline& position, double time) {
    // s; from: measured, planar_car seeds 12 and 14: over 0.14 s lags wander by 10 ms from round to round,
    // over 0.3 and 0.5 s they settle within 1 ms of the truth
    constexpr double kLeastSpan = 0.3;
    const UniformKnots& knots = position.knots();
    // Samples that are read earlier or later leave the last segments to nobody.
    const double margin = std::min(knots.spacing, 0.2 * (knots.End() - knots.start));
    const double start = knots.start + margin, end = knots.End() - margin;
    const double half = 0.5 * std::min(std::max(kLeastSpan, knots.spacing), end - start);
    const double from = std::clamp(time - half, start, end - half);
    const double to = std::clamp(time + half, start + half, end);
    return (position.Acceleration(SplineBasis(knots, to)) - position.Acceleration(SplineBasis(knots, from))) /
           (to - from);
  }

  // Its components' columns; the specific force's are zero but for what Evaluate fills.
  static void FillGyroscope(const ImuCalibration& imu, const So3Spline::Value& value,
                            const So3Spline::Jacobians& J, Jacobian* jacobian) {
    jacobian->setZero();
    for (int j = 0; j < 4; ++j) {
      jacobian->block<3, 3>(3 * j, 0) = (imu.gyroscope_matrix * J.angular_velocity[j]).transpose();
    }
    jacobian->block<3, 3>(kBias, 0).setIdentity();
    jacobian->block<3, 3>(kAlignment, 0) = (imu.gyroscope_matrix * Hat(value.angular_velocity)).transpose();
    const Eigen::Vector3d rates = imu.gyroscope_matrix * value.angular_velocity;
    int lower = kMatrices + 6;
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c <= r; ++c) (*jacobian)(lower++, r) = rates[c];
    }
  }
};

}  // namespace mlic
