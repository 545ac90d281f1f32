#include "mlic_core/problem/landmark_terms.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mlic_core/common/parallel.h"
#include "mlic_core/problem/landmark_rows.h"

namespace mlic {

using namespace landmark_rows;

namespace {

// Places of one row's parts in the calibration vector.
struct CameraColumns {
  CameraColumns(const Layout& layout, const CalibrationState& state, int camera) {
    const bool rolling = layout.Readout(camera) >= 0;
    pose = layout.Camera(camera);
    inner = rolling ? layout.Readout(camera) : layout.Intrinsics(camera);
    from = rolling ? kReadout : kIntrinsics;
    count = static_cast<int>(state.cameras[camera].intrinsics.parameters.size()) + (rolling ? 1 : 0);
    drift = layout.Drift(CameraId(camera));
  }
  // A LiDAR has nothing but its pose and clock.
  static CameraColumns OfLidar(const Layout& layout, int lidar) {
    CameraColumns columns;
    columns.pose = columns.inner = Layout::Lidar(lidar);
    columns.from = kReadout;
    columns.count = 0;
    columns.drift = layout.Drift(LidarId(lidar));
    return columns;
  }
  int pose;
  int inner;
  int from;
  int count;
  int drift;  // -1: not estimated

 private:
  CameraColumns() = default;
};

void AddToCalibration(const CameraColumns& c, const Square& H, LandmarkCoupling* landmark, Accumulator* sum) {
  sum->corner.block<7, 7>(c.pose, c.pose) += H.block<7, 7>(kExtrinsic, kExtrinsic);
  sum->corner.block(c.inner, c.pose, c.count, 7) += H.block(c.from, kExtrinsic, c.count, 7);
  sum->corner.block(c.pose, c.inner, 7, c.count) += H.block(kExtrinsic, c.from, 7, c.count);
  sum->corner.block(c.inner, c.inner, c.count, c.count) += H.block(c.from, c.from, c.count, c.count);
  sum->gradient_calibration.segment<7>(c.pose) += H.block<7, 1>(kExtrinsic, kResidual);
  sum->gradient_calibration.segment(c.inner, c.count) += H.block(c.from, kResidual, c.count, 1);
  landmark->own += H.block<3, 3>(kPoint, kPoint);
  landmark->gradient += H.block<3, 1>(kPoint, kResidual);
  landmark->calibration.middleRows<7>(c.pose) += H.block<7, 3>(kExtrinsic, kPoint);
  landmark->calibration.middleRows(c.inner, c.count) += H.block(c.from, kPoint, c.count, 3);
  if (c.drift < 0) return;
  const auto add = [&](int at, int from, int count) {
    sum->corner.block(at, c.drift, count, 1) += H.block(from, kDrift, count, 1);
    sum->corner.block(c.drift, at, 1, count) += H.block(kDrift, from, 1, count);
  };
  add(c.pose, kExtrinsic, Layout::kOfSensor);
  add(c.inner, c.from, c.count);
  sum->corner(c.drift, c.drift) += H(kDrift, kDrift);
  sum->gradient_calibration[c.drift] += H(kDrift, kResidual);
  landmark->calibration.row(c.drift) += H.block<1, 3>(kDrift, kPoint);
}

void AddToKnots(const CameraColumns& c, const KnotColumns& columns, const Square& H, CouplingSlots* slots,
                Accumulator* sum) {
  for (int a = 0; a < 8; ++a) {
    sum->gradient_knots.segment<3>(sum->Local(columns[a])) += H.block<3, 1>(3 * a, kResidual);
    sum->border.block<7, 3>(c.pose, sum->Local(columns[a])) += H.block<7, 3>(kExtrinsic, 3 * a);
    sum->border.block(c.inner, sum->Local(columns[a]), c.count, 3) += H.block(c.from, 3 * a, c.count, 3);
    if (c.drift >= 0)
      sum->border.block<1, 3>(c.drift, sum->Local(columns[a])) += H.block<1, 3>(kDrift, 3 * a);
    slots->Block(columns[a]) += H.block<3, 3>(3 * a, kPoint);
    for (int b = 0; b < 8; ++b) {
      if (columns[a] >= columns[b]) sum->AddBand(columns[a], columns[b], H.block<3, 3>(3 * a, 3 * b));
    }
  }
}

void AddLidarPoint(const LinearizationPoint& at, std::size_t d, std::size_t p, const Eigen::Matrix3d& J_chart,
                   CouplingSlots* slots, LandmarkCoupling* landmark, Accumulator* sum) {
  WithLidarRows(at, d, p, J_chart, &sum->cost, [&](const Bases& bases, const LidarRows& rows) {
    const Square H = rows * rows.transpose();
    const CameraColumns columns =
        CameraColumns::OfLidar(at.layout, at.problem.drives[d].landmarks.lidar_points[p].lidar);
    if (!at.problem.fix_trajectory) {
      AddToKnots(columns, KnotColumns(at.layout, d, bases.rotation.first, bases.position.first), H, slots,
                 sum);
    }
    AddToCalibration(columns, H, landmark, sum);
  });
}

}  // namespace

void AddLandmarks(const LinearizationPoint& at, std::size_t d, std::size_t begin, std::size_t end,
                  LandmarkCoupling* couplings, Accumulator* sum) {
  const LandmarkSet& set = at.problem.drives[d].landmarks;
  const bool with_knots = !at.problem.fix_trajectory;
  ObservationRows observations(at, d);
  CouplingSlots slots(at.layout.knots);
  Square H;
  for (std::size_t p = begin; p < end; ++p) {
    LandmarkCoupling& landmark = couplings[p];
    landmark.calibration = Eigen::MatrixXd::Zero(at.layout.calibration, 3);
    const PointChart chart(set.points[p]);
    const Eigen::Matrix3d J_chart = chart.Jacobian().transpose();
    const auto add = [&](const CameraObservation& observation, const Bases& bases, const Rows& rows) {
      const CameraColumns columns(at.layout, at.state, observation.given.camera);
      if (with_knots) {
        H.noalias() = rows * rows.transpose();
        AddToKnots(columns, KnotColumns(at.layout, d, bases.rotation.first, bases.position.first), H, &slots,
                   sum);
      } else {
        constexpr int kRest = kColumns - kExtrinsic;  // from: structural, places of columns
        H.bottomRightCorner<kRest, kRest>().noalias() =
            rows.bottomRows<kRest>() * rows.bottomRows<kRest>().transpose();
      }
      AddToCalibration(columns, H, &landmark, sum);
    };
    observations.ForEach(p, J_chart, &sum->cost, add);
    if (set.IsOnMap(p)) AddLidarPoint(at, d, p, J_chart, &slots, &landmark, sum);
    slots.Finish(&landmark);
  }
}

std::vector<ReprojectionRows> RowsOfLandmark(const LinearizationPoint& at, std::size_t d, std::size_t p) {
  const Eigen::Matrix3d J_chart = PointChartJacobian(at.problem.drives[d].landmarks.points[p]).transpose();
  std::vector<ReprojectionRows> observations;
  double cost = 0.0;
  const auto add = [&](const CameraObservation& observation, const Bases& bases, const Rows& rows) {
    const CameraColumns camera(at.layout, at.state, observation.given.camera);
    ReprojectionRows out{&observation.given,
                         observation.time,
                         {},
                         {},
                         rows.middleRows<3>(kPoint),
                         rows.row(kResidual).transpose()};
    const KnotColumns knots(at.layout, d, bases.rotation.first, bases.position.first);
    for (int i = 0; i < kExtrinsic; ++i) out.columns.push_back(knots[i / 3] + i % 3);
    for (int i = 0; i < 7; ++i) out.columns.push_back(at.layout.knots + camera.pose + i);
    for (int i = 0; i < camera.count; ++i) out.columns.push_back(at.layout.knots + camera.inner + i);
    const bool drifts = camera.drift >= 0;
    if (drifts) out.columns.push_back(at.layout.knots + camera.drift);
    out.jacobian.resize(static_cast<Eigen::Index>(out.columns.size()), 2);
    out.jacobian << rows.topRows<kExtrinsic + 7>(), rows.middleRows(camera.from, camera.count),
        rows.middleRows(kDrift, drifts ? 1 : 0);
    observations.push_back(std::move(out));
  };
  ObservationRows(at, d).ForEach(p, J_chart, &cost, add);
  return observations;
}

double LandmarkCost(const LinearizationPoint& at, std::size_t d, std::size_t begin, std::size_t end) {
  const LandmarkSet& set = at.problem.drives[d].landmarks;
  const SplitSpline& trajectory = at.state.drives[d].trajectory;
  const std::vector<Reprojection::Camera> cameras = Cameras(at.state);
  double cost = 0.0;
  for (std::size_t p = begin; p < end; ++p) {
    for (std::size_t k = set.begin[p]; k < set.begin[p + 1]; ++k) {
      const LandmarkObservation& o = set.observations[k];
      const CameraObservation observation(o, at.state, trajectory.Middle());
      if (!trajectory.Contains(observation.time)) continue;
      Eigen::Vector2d residual;
      const bool seen = observation.Evaluate(trajectory, cameras, set.points[p].position, &residual);
      double weight;
      cost += RobustCost(seen ? (o.shape.cast<double>() * residual).norm() / o.sigma : kLostSigmas, &weight);
    }
    if (!set.IsOnMap(p)) continue;
    const LidarPointObservation& observation = set.lidar_points[p];
    const SensorCalibration& lidar = at.state.lidars[observation.lidar];
    const double t = lidar.OnImuClock(observation.time, trajectory.Middle());
    if (!trajectory.Contains(t)) continue;
    const Bases bases(trajectory, t);
    cost += ResidualOf(observation)
                .Evaluate(trajectory, bases.rotation, bases.position, lidar, set.points[p].position)
                .squaredNorm();
  }
  return cost;
}

Eigen::Matrix3d PointChartJacobian(const PointLandmark& point) { return PointChart(point).Jacobian(); }

void MovePoint(const Eigen::Vector3d& step, PointLandmark* point) {
  const PointChart chart(*point);
  // A point does not pass through infinity, nor into its cameras at once.
  const double inverse_distance = std::clamp(chart.inverse_distance + step[2], 0.2 * chart.inverse_distance,
                                             5.0 * chart.inverse_distance);
  point->position = chart.anchor + (chart.bearing + step[0] * chart.u + step[1] * chart.v) / inverse_distance;
}

std::vector<Eigen::Vector2d> LandmarkResiduals(const LandmarkSet& set, const CalibrationState& state,
                                               std::size_t d) {
  const SplitSpline& trajectory = state.drives[d].trajectory;
  const std::vector<Reprojection::Camera> cameras = Cameras(state);
  std::vector<Eigen::Vector2d> residuals(set.observations.size(),
                                         Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN()));
  ParallelFor(set.points.size(), [&](std::size_t p) {
    for (std::size_t k = set.begin[p]; k < set.begin[p + 1]; ++k) {
      const CameraObservation observation(set.observations[k], state, trajectory.Middle());
      if (!trajectory.Contains(observation.time)) continue;
      observation.Evaluate(trajectory, cameras, set.points[p].position, &residuals[k]);
    }
  });
  return residuals;
}

}  // namespace mlic
