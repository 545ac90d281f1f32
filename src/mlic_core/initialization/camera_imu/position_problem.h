#pragma once

#include <Eigen/Core>
#include <vector>

#include "mlic_core/initialization/camera_imu/observations.h"
#include "mlic_core/solver/normal_equations.h"

namespace mlic {

// The parts of the linear problem of positions (positions.h).

// Where the unknowns stand: control points of all drives in order of time; then, in the border, gravity knots
// and bias of each drive, then lever arms.
struct PositionUnknowns {
  // longest: s, of a point's observations.
  PositionUnknowns(const KnownRotations& known, double longest);

  // The two gravity knots about a time and the share of the second.
  void GravityAt(std::size_t drive, double time, int* first, double* share) const;

  std::vector<UniformKnots> knots;                 // of each drive
  std::vector<int> first_knot;                     // scalar, of each drive
  std::vector<int> gravity;                        // first scalar of each drive's
  std::vector<std::vector<double>> gravity_times;  // of each drive, s
  std::vector<int> bias, lever;                    // of each drive, of each camera
  int knot_scalars = 0, border = 0, bandwidth = 0;
};

// One linear measurement of three components: residual = sum of coefficients * unknowns - value.
struct LinearRow {
  int knot = 0;               // scalar of the first of four control points
  Eigen::Vector4d weights;    // of them
  int border[3];              // scalars of border blocks
  Eigen::Matrix3d blocks[3];  // their coefficients
  int border_count = 0;

  // Of these unknowns, without the value.
  Eigen::Vector3d Of(const Eigen::VectorXd& knots, const Eigen::VectorXd& border_values) const;
};

// p''(t) - g(t) + R b, R of the IMU.
LinearRow ForceRow(const PositionUnknowns& unknowns, std::size_t drive, double time,
                   const Eigen::Matrix3d& R);
// p(t) + R l.
LinearRow ObservationRow(const PositionUnknowns& unknowns, const PointObservations& point,
                         const DirectionObservation& observation);

// Information of an observation across its ray, 1/m^2, and where the point is seen, from the camera, m. The
// ray is that to the point as found before: across the direction that was measured, noise would make all
// distances shrink.
Eigen::Matrix3d WeightOf(const DirectionObservation& observation);
Eigen::Vector3d OffsetOf(const DirectionObservation& observation);
// Of a point, from its observations alone; along the rays of points without parallax next to nothing is
// known.
Eigen::Matrix3d PointCovariance(const PointObservations& point);

// Normal equations of the unknowns themselves, not of steps: H x = -g.
void AddRow(const LinearRow& row, const Eigen::Matrix3d& W, const Eigen::Vector3d& value, Accumulator* sum);
// All observations of a point, the point eliminated.
void AddPoint(const PositionUnknowns& unknowns, const PointObservations& point, Accumulator* sum);
// First positions, biases, guesses of lever arms, and gravity that turns slowly. gravity: the border as it
// was found in the round before, where the length of gravity is to be kept; else null, and no bias is looked
// for.
void AddPriors(const PositionUnknowns& unknowns, const KnownRotations& known, const Eigen::VectorXd* gravity,
               Accumulator* sum);

}  // namespace mlic
