#include "mlic_core/problem/settle_points.h"

#include <algorithm>

#include "mlic_core/common/parallel.h"
#include "mlic_core/geometry/symmetric_matrix.h"
#include "mlic_core/problem/landmark_rows.h"
#include "mlic_core/problem/landmark_terms.h"

namespace mlic {

using namespace landmark_rows;

namespace {

// What the observations of one point say of it: J^T J and J^T r of its three parameters.
struct PointEquations {
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  double cost = 0.0;

  template <typename AnyRows>
  void Add(const AnyRows& rows) {
    const auto by_point = rows.template middleRows<3>(kPoint);
    information += by_point * by_point.transpose();
    gradient += by_point * rows.row(kResidual).transpose();
  }
};

PointEquations EquationsOf(const LinearizationPoint& at, std::size_t d, std::size_t p,
                           ObservationRows* observations) {
  const LandmarkSet& set = at.problem.drives[d].landmarks;
  const Eigen::Matrix3d J_chart = PointChart(set.points[p]).Jacobian().transpose();
  PointEquations equations;
  observations->ForEach(
      p, J_chart, &equations.cost,
      [&](const CameraObservation&, const Bases&, const Rows& rows) { equations.Add(rows); });
  if (set.IsOnMap(p)) {
    WithLidarRows(at, d, p, J_chart, &equations.cost,
                  [&](const Bases&, const LidarRows& rows) { equations.Add(rows); });
  }
  return equations;
}

// Gauss-Newton with Marquardt damping in one point, from where it is or was, whichever is better, for as long
// as it lowers the cost by more than next to nothing.
void SettlePoint(const LinearizationPoint& at, std::size_t d, std::size_t p, const PointLandmark& was,
                 ObservationRows* observations, PointLandmark* point) {
  constexpr int kMost = 15;             // from: guard, three do as a rule
  constexpr double kNegligible = 1e-3;  // of the cost, and of a sigma squared; from: guard
  PointEquations equations = EquationsOf(at, d, p, observations);
  const PointLandmark moved_to = *point;
  *point = was;
  const PointEquations before = EquationsOf(at, d, p, observations);
  if (!(equations.cost <= before.cost)) {  // also where it is not a number
    equations = before;
  } else {
    *point = moved_to;
  }
  double damping = 1e-9;  // from: guard, directions that no observation shows
  for (int i = 0; i < kMost; ++i) {
    Eigen::Matrix3d H = equations.information;
    H.diagonal() *= 1.0 + damping;
    const Eigen::Vector3d step = -SolveSymmetric3(H, equations.gradient);
    const PointLandmark last = *point;
    if (step.allFinite()) MovePoint(step, point);
    const PointEquations moved = EquationsOf(at, d, p, observations);
    if (!(moved.cost < equations.cost)) {
      *point = last;
      damping = std::max(1e-4, 10.0 * damping);
      continue;
    }
    const bool settled = equations.cost - moved.cost < kNegligible * (1.0 + moved.cost);
    equations = moved;
    if (settled) return;
    damping *= 0.1;
  }
}

}  // namespace

void SettlePoints(const CalibrationState& state, const Layout& layout,
                  const std::vector<LandmarkGeometry>& before, JointProblem* problem) {
  const LinearizationPoint at{*problem, state, layout};
  for (std::size_t d = 0; d < problem->drives.size(); ++d) {
    std::vector<PointLandmark>& points = problem->drives[d].landmarks.points;
    ParallelChunks(points.size(), kLinearizationChunks, [&](std::size_t, std::size_t begin, std::size_t end) {
      ObservationRows observations(at, d);
      for (std::size_t p = begin; p < end; ++p) {
        SettlePoint(at, d, p, before[d].points[p], &observations, &points[p]);
      }
    });
  }
}

}  // namespace mlic
