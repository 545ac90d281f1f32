#include "mlic_core/problem/linearizer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "mlic_core/common/parallel.h"
#include "mlic_core/geometry/symmetric_matrix.h"
#include "mlic_core/problem/imu_terms.h"
#include "mlic_core/problem/landmark_terms.h"
#include "mlic_core/problem/plane_terms.h"

namespace mlic {
namespace {

Eigen::Vector3d LandmarkStep(const LandmarkCoupling& tie, const Eigen::VectorXd& delta) {
  Eigen::Vector3d right = tie.gradient + tie.calibration.transpose() * delta.tail(tie.calibration.rows());
  for (std::size_t b = 0; b < tie.columns.size(); ++b) {
    right += tie.blocks[b].transpose() * delta.segment<3>(tie.columns[b]);
  }
  Eigen::Matrix3d own = tie.own;
  own.diagonal().array() += 1e-9;
  return -SolveSymmetric3(own, right);
}

// The times of measurements, IMU clock.
struct TimeSpan {
  double begin = std::numeric_limits<double>::infinity();
  double end = -std::numeric_limits<double>::infinity();
  void Include(double time) {
    begin = std::min(begin, time);
    end = std::max(end, time);
  }
};

// One part of a drive's landmarks and IMU samples.
struct Part {
  std::size_t chunk;
  std::size_t plane_begin = 0, plane_end = 0, point_begin = 0, point_end = 0;
};

std::vector<Part> PartsOf(const JointProblem& problem, std::size_t d) {
  std::vector<Part> parts(kLinearizationChunks);
  for (std::size_t c = 0; c < parts.size(); ++c) parts[c].chunk = c;
  if (!problem.drives[d].planes.planes.empty()) {
    const std::vector<std::size_t> cut = CutByObservations(problem.drives[d].planes.begin);
    for (Part& part : parts) {
      part.plane_begin = cut[part.chunk];
      part.plane_end = cut[part.chunk + 1];
    }
  }
  if (!problem.drives[d].landmarks.points.empty()) {
    const std::vector<std::size_t> cut = CutByObservations(problem.drives[d].landmarks.begin);
    for (Part& part : parts) {
      part.point_begin = cut[part.chunk];
      part.point_end = cut[part.chunk + 1];
    }
  }
  return parts;
}

TimeSpan SpanOf(const LinearizationPoint& at, std::size_t d, const Part& part) {
  TimeSpan span;
  const double middle = at.state.drives[d].trajectory.Middle();
  const auto [imu_begin, imu_end] = ImuPart(at, d, part.chunk);
  const std::vector<ImuSample>& imu = at.problem.dataset->drives[d].imu;
  for (std::size_t k = imu_begin; k < imu_end; ++k) {
    span.Include(imu[k].time);
    span.Include(imu[k].time - at.state.accelerometer_lag);
  }
  if (part.plane_begin < part.plane_end) {
    const PlaneAssociation& planes = at.problem.drives[d].planes;
    for (std::size_t k = planes.begin[part.plane_begin]; k < planes.begin[part.plane_end]; ++k) {
      const PlaneObservation& o = planes.observations[k];
      span.Include(at.state.lidars[o.lidar].OnImuClock(o.time, middle));
    }
  }
  if (part.point_begin < part.point_end) {
    const LandmarkSet& points = at.problem.drives[d].landmarks;
    for (std::size_t k = points.begin[part.point_begin]; k < points.begin[part.point_end]; ++k) {
      const CameraCalibration& camera = at.state.cameras[points.observations[k].camera];
      const double time = camera.sensor.OnImuClock(points.observations[k].time, middle);
      // A pixel's row may lie a little off the image.
      span.Include(time - std::abs(camera.readout));
      span.Include(time + 2.0 * std::abs(camera.readout));
    }
    for (std::size_t p = part.point_begin; p < part.point_end; ++p) {
      if (!points.IsOnMap(p)) continue;
      const LidarPointObservation& observation = points.lidar_points[p];
      span.Include(at.state.lidars[observation.lidar].OnImuClock(observation.time, middle));
    }
  }
  return span;
}

// For the columns of the control points that measurements at these times touch; none if the trajectory is
// held. Landmarks come in order of time, so parts are narrow.
Accumulator NarrowAccumulator(const LinearizationPoint& at, std::size_t d, const TimeSpan& span) {
  const Layout& layout = at.layout;
  if (at.problem.fix_trajectory || span.begin > span.end) {
    return Accumulator(0, layout.bandwidth, layout.calibration);
  }
  const SplitSpline& trajectory = at.state.drives[d].trajectory;
  const double begin = std::clamp(span.begin, trajectory.Start(), trajectory.End());
  const double end = std::clamp(span.end, trajectory.Start(), trajectory.End());
  const KnotColumns first(layout, d, SplineBasis(trajectory.rotation.knots(), begin).first,
                          SplineBasis(trajectory.position.knots(), begin).first);
  const KnotColumns last(layout, d, SplineBasis(trajectory.rotation.knots(), end).first,
                         SplineBasis(trajectory.position.knots(), end).first);
  const int from = std::min(first[0], first[4]), to = std::max(last[3], last[7]) + 3;
  return Accumulator(to - from, layout.bandwidth, layout.calibration, from);
}

}  // namespace

Accumulator Linearize(const LinearizationPoint& at, std::vector<LandmarkCoupling>* landmarks) {
  const Layout& layout = at.layout;
  const JointProblem& problem = at.problem;
  Accumulator sum(layout.knots, layout.bandwidth, layout.calibration);
  const PlaneTerms plane_terms(at);
  landmarks->clear();
  for (std::size_t d = 0; d < at.state.drives.size(); ++d) {
    const std::size_t planes = problem.drives[d].planes.planes.size();
    const std::size_t points = problem.drives[d].landmarks.points.size();
    const std::size_t first = landmarks->size();
    landmarks->resize(first + planes + points);
    LandmarkCoupling* plane_couplings = landmarks->data() + first;
    LandmarkCoupling* point_couplings = plane_couplings + planes;
    const std::vector<Part> parts = PartsOf(problem, d);
    std::vector<std::optional<Accumulator>> sums(parts.size());
    ParallelFor(parts.size(), [&](std::size_t c) {
      const Part& part = parts[c];
      // A held trajectory has no columns, and the problem perhaps no IMU.
      sums[c] = NarrowAccumulator(at, d, problem.fix_trajectory ? TimeSpan() : SpanOf(at, d, part));
      if (planes > 0) plane_terms.Add(d, part.plane_begin, part.plane_end, plane_couplings, &*sums[c]);
      if (points > 0) AddLandmarks(at, d, part.point_begin, part.point_end, point_couplings, &*sums[c]);
      if (!problem.fix_trajectory) AddImu(at, d, c, &*sums[c]);
    });
    for (const std::optional<Accumulator>& part : sums) sum += *part;
    if (problem.fix_trajectory) continue;
    AddPoses(at, d, &sum);
    AddGauge(at, d, &sum);
  }
  return sum;
}

double Cost(const LinearizationPoint& at) {
  const JointProblem& problem = at.problem;
  const PlaneTerms plane_terms(at);
  double cost = 0.0;
  for (std::size_t d = 0; d < at.state.drives.size(); ++d) {
    const std::vector<Part> parts = PartsOf(problem, d);
    std::vector<double> costs(parts.size(), 0.0);
    ParallelFor(parts.size(), [&](std::size_t c) {
      const Part& part = parts[c];
      if (part.plane_begin < part.plane_end) {
        costs[c] += plane_terms.Cost(d, part.plane_begin, part.plane_end);
      }
      if (part.point_begin < part.point_end) {
        costs[c] += LandmarkCost(at, d, part.point_begin, part.point_end);
      }
      if (!problem.fix_trajectory) costs[c] += ImuCost(at, d, c);
    });
    for (const double one : costs) cost += one;
    if (!problem.fix_trajectory) cost += PoseCost(at, d);
  }
  return cost;
}

std::vector<Eigen::Vector3d> LandmarkSteps(const std::vector<LandmarkCoupling>& couplings,
                                           const Eigen::VectorXd& delta) {
  std::vector<Eigen::Vector3d> steps(couplings.size());
  ParallelFor(steps.size(), [&](std::size_t i) { steps[i] = LandmarkStep(couplings[i], delta); });
  return steps;
}

void MoveLandmarks(const std::vector<Eigen::Vector3d>& steps, JointProblem* problem) {
  std::size_t at = 0;
  for (DriveTerms& drive : problem->drives) {
    for (MapPlane& plane : drive.planes.planes) MovePlane(steps[at++], &plane);
    for (PointLandmark& point : drive.landmarks.points) MovePoint(steps[at++], &point);
  }
}

}  // namespace mlic
