#include "mlic_core/trajectory/split_spline.h"

#include <algorithm>

#include "mlic_core/common/error.h"

namespace mlic {

PositionSpline::PositionSpline(const UniformKnots& knots, std::vector<Eigen::Vector3d> control_points)
    : knots_(knots), control_points_(std::move(control_points)) {
  Check(static_cast<int>(control_points_.size()) == knots_.count,
        "PositionSpline: wrong number of control points");
}

void PositionSpline::Update(const Eigen::VectorXd& delta, const std::vector<int>& offsets) {
  for (std::size_t j = 0; j < control_points_.size(); ++j) control_points_[j] += delta.segment<3>(offsets[j]);
}

double SplitSpline::Start() const { return std::max(rotation.knots().start, position.knots().start); }

double SplitSpline::End() const { return std::min(rotation.knots().End(), position.knots().End()); }

RigidTransform SplitSpline::Pose(double time) const {
  return {rotation.Rotation(time), position.Position(SplineBasis(position.knots(), time))};
}

}  // namespace mlic
