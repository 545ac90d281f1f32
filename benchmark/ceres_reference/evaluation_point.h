#pragma once

#include <ceres/evaluation_callback.h>

#include <array>
#include <vector>

#include "mlic_core/factors/point_to_plane.h"
#include "mlic_core/factors/reprojection.h"
#include "mlic_core/problem/joint_problem.h"
#include "mlic_core/problem/state.h"

namespace mlic::ceres_reference {

using RotationBlock = std::array<double, 4>;  // quaternion x, y, z, w
using PositionBlock = std::array<double, 3>;
using PlaneBlock = std::array<double, 7>;  // normal, offset, centre
using PointBlock = std::array<double, 6>;  // position, anchor

PlaneBlock BlockOf(const MapPlane& plane);
PointBlock BlockOf(const PointLandmark& point);
MapPlane PlaneOf(const double* block);  // nothing but what the block holds
PointLandmark PointOf(const double* block);

// The parameters where Ceres evaluates the problem, and what all residuals share there: the splines with what
// they derive from neighbouring control points, and the extrinsic rotations as matrices. The state's sensors,
// biases and matrices are themselves Ceres's parameter blocks; its trajectories follow the control points.
class EvaluationPoint : public ceres::EvaluationCallback {
 public:
  EvaluationPoint(const CalibrationState& start, const std::vector<DriveTerms>& terms);
  EvaluationPoint(const EvaluationPoint&) = delete;
  EvaluationPoint& operator=(const EvaluationPoint&) = delete;

  // Called by Ceres before residuals are evaluated where the blocks are now.
  void PrepareForEvaluation(bool evaluate_jacobians, bool new_evaluation_point) override;

  struct DriveBlocks {
    std::vector<RotationBlock> rotations;
    std::vector<PositionBlock> positions;
    std::vector<PlaneBlock> planes;
    std::vector<PointBlock> points;
  };

  CalibrationState state;
  std::vector<DriveBlocks> drives;
  std::vector<PointToPlane::Extrinsic> lidars;
  std::vector<Reprojection::Camera> cameras;
};

}  // namespace mlic::ceres_reference
