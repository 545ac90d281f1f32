#pragma once

#include "mlic_core/problem/linear_terms.h"

namespace mlic {

// Adds the reprojection errors of the point landmarks [begin, end) of one drive; couplings: one for each
// point of the drive, filled for these.
void AddLandmarks(const LinearizationPoint& at, std::size_t drive, std::size_t begin, std::size_t end,
                  LandmarkCoupling* couplings, Accumulator* sum);

// One observation of a point landmark as AddLandmarks takes it: divided by its sigma, weighted by the robust
// loss.
struct ReprojectionRows {
  const LandmarkObservation* observation;
  double time;                                        // IMU clock
  std::vector<int> columns;                           // in the vector of all unknowns (Layout)
  Eigen::Matrix<double, Eigen::Dynamic, 2> jacobian;  // of those unknowns (rows), for each residual
  Eigen::Matrix<double, 3, 2> by_point;               // of the point's three parameters
  Eigen::Vector2d residual;
};

// Of those observations of one point that the cameras can see. The trajectory is free.
std::vector<ReprojectionRows> RowsOfLandmark(const LinearizationPoint& at, std::size_t drive,
                                             std::size_t point);

// What AddLandmarks adds to the cost.
double LandmarkCost(const LinearizationPoint& at, std::size_t drive, std::size_t begin, std::size_t end);

// The point moved by a step in its three parameters: two of the bearing from its anchor, and the inverse
// distance.
void MovePoint(const Eigen::Vector3d& step, PointLandmark* point);

// Of the point's position to these three parameters.
Eigen::Matrix3d PointChartJacobian(const PointLandmark& point);

// Reprojection errors in pixels of all observations of one drive's landmarks, in their order; not a number
// where the point cannot be projected.
std::vector<Eigen::Vector2d> LandmarkResiduals(const LandmarkSet& landmarks, const CalibrationState& state,
                                               std::size_t drive);

}  // namespace mlic
