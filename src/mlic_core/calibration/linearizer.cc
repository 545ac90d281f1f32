#include "mlic_core/calibration/linearizer.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "mlic_core/calibration/imu_terms.h"
#include "mlic_core/calibration/landmark_terms.h"
#include "mlic_core/calibration/plane_terms.h"
#include "mlic_core/common/parallel.h"

namespace mlic {
namespace {

Eigen::Vector3d LandmarkStep(const LandmarkTies& tie, const Eigen::VectorXd& delta) {
  Eigen::Vector3d right = tie.gradient + tie.calibration.transpose() * delta.tail(tie.calibration.rows());
  for (std::size_t b = 0; b < tie.columns.size(); ++b) {
    right += tie.blocks[b].transpose() * delta.segment<3>(tie.columns[b]);
  }
  Eigen::Matrix3d own = tie.own;
  own.diagonal().array() += 1e-9;
  return -own.ldlt().solve(right);
}

}  // namespace

Accumulator Linearize(const LinearizationPoint& at, std::vector<LandmarkTies>* landmarks) {
  const Layout& layout = at.layout;
  const JointProblem& problem = at.problem;
  Accumulator sum(layout.knots, layout.bandwidth, layout.calibration);
  const PlaneTerms plane_terms(at);
  landmarks->clear();
  for (std::size_t d = 0; d < at.state.drives.size(); ++d) {
    const std::size_t planes = d < problem.planes.size() ? problem.planes[d].planes.size() : 0;
    const std::size_t points = d < problem.landmarks.size() ? problem.landmarks[d].points.size() : 0;
    const std::size_t first = landmarks->size();
    landmarks->resize(first + planes + points);
    std::vector<std::size_t> plane_cut, point_cut;
    if (planes > 0) plane_cut = CutByObservations(problem.planes[d].begin);
    if (points > 0) point_cut = CutByObservations(problem.landmarks[d].begin);
    std::vector<Accumulator> parts(kLinearizationChunks,
                                   Accumulator(layout.knots, layout.bandwidth, layout.calibration));
    ParallelFor(kLinearizationChunks, [&](std::size_t c) {
      if (planes > 0)
        plane_terms.Add(d, plane_cut[c], plane_cut[c + 1], landmarks->data() + first, &parts[c]);
      if (points > 0) {
        AddLandmarks(at, d, point_cut[c], point_cut[c + 1], landmarks->data() + first + planes, &parts[c]);
      }
      if (!problem.hold_trajectory) AddImu(at, d, c, &parts[c]);
    });
    for (const Accumulator& part : parts) sum += part;
    if (problem.hold_trajectory) continue;
    if (d < problem.poses.size()) AddPoses(at, d, &sum);
    AddGauge(at, d, &sum);
  }
  return sum;
}

void MoveLandmarks(const std::vector<LandmarkTies>& ties, const Eigen::VectorXd& delta,
                   JointProblem* problem) {
  std::size_t at = 0;
  const std::size_t drives = std::max(problem->planes.size(), problem->landmarks.size());
  for (std::size_t d = 0; d < drives; ++d) {
    if (d < problem->planes.size()) {
      for (MapPlane& plane : problem->planes[d].planes) MovePlane(LandmarkStep(ties[at++], delta), &plane);
    }
    if (d < problem->landmarks.size()) {
      for (PointLandmark& point : problem->landmarks[d].points) {
        MovePoint(LandmarkStep(ties[at++], delta), &point);
      }
    }
  }
}

}  // namespace mlic
