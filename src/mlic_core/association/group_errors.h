#pragma once

#include <vector>

#include "mlic_core/lidar/plane_map.h"
#include "mlic_core/problem/joint_problem.h"
#include "mlic_core/problem/observations.h"
#include "mlic_core/problem/state.h"

namespace mlic {

// What points that one LiDAR puts on one plane within a second (GroupBegins) err by together: uneven ground,
// a beam's pointing, what the trajectory cannot follow.

// The variance of the sum of so many points by that of as many independent ones (PlaneNoise::shared).
double GrowthOf(const PlaneNoise& noise, double points);

// Observations of a plane count for less by as much as what their group shares makes the variance of its sum
// grow (PlaneObservation::weight).
void WeighGroups(const std::vector<PlaneNoise>& noise, std::size_t plane, PlaneAssociation* association);

// PlaneNoise::shared of each LiDAR from the sums of its groups' residuals: their mean square over that of
// white residuals, by octaves of points, never falling. Weights that groups have already are taken out again.
void MeasureSharedErrors(const std::vector<DriveTerms>& drives, const CalibrationState& state,
                         std::vector<PlaneNoise>* noise);

// By how much what groups share makes points worth less than their weights say. Over groups of points with
// whitened residuals r, weights w and their sums T = sum(w r):
//   sum of T^2 / sum of (sum of w - what the plane follows of it),
// the variance of the sums against that of white residuals (docs/method.md, section 11). Large groups count
// for more, as they do in the solve. One for independent points, and never less.
double CorrelationFactor(const std::vector<DriveTerms>& drives, const CalibrationState& state);

}  // namespace mlic
