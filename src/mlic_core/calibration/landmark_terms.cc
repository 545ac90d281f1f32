#include "mlic_core/calibration/landmark_terms.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mlic_core/common/parallel.h"
#include "mlic_core/factors/reprojection.h"

namespace mlic {
namespace {

// The cost of a point that its camera cannot see any more, as if it were this many sigmas off.
constexpr double kLostSigmas = 100.0;

// Bearing and inverse distance of a point from its anchor: position = anchor + (bearing + x u + y v) / (rho +
// z).
struct PointChart {
  explicit PointChart(const PointLandmark& point) : anchor(point.anchor) {
    const Eigen::Vector3d ray = point.position - point.anchor;
    const double distance = ray.norm();
    bearing = ray / distance;
    inverse_distance = 1.0 / distance;
    u = bearing.unitOrthogonal();
    v = bearing.cross(u);
  }
  // Of the position to the three parameters.
  Eigen::Matrix3d Jacobian() const {
    Eigen::Matrix3d J;
    J << u, v, -bearing / inverse_distance;
    return J / inverse_distance;
  }
  Eigen::Vector3d anchor, bearing, u, v;
  double inverse_distance;
};

// One residual's row here: as in Reprojection up to the readout, then intrinsics (neighbours of the readout
// in the layout as well), then the point in its chart, then the residual.
constexpr int kExtrinsic = Reprojection::kExtrinsic;
constexpr int kReadout = Reprojection::kReadout;
constexpr int kIntrinsics = kReadout + 1;
constexpr int kPoint = kIntrinsics + kMostCameraParameters;
constexpr int kResidual = kPoint + 3;
constexpr int kColumns = kResidual + 1;
using Rows = Eigen::Matrix<double, kColumns, 2>;
using Square = Eigen::Matrix<double, kColumns, kColumns>;

// Places of one row's parts in the calibration vector.
struct CameraColumns {
  CameraColumns(const Layout& layout, const CalibrationState& state, int camera) {
    const bool rolling = layout.Readout(camera) >= 0;
    pose = layout.Camera(camera);
    inner = rolling ? layout.Readout(camera) : layout.Intrinsics(camera);
    from = rolling ? kReadout : kIntrinsics;
    count = static_cast<int>(state.cameras[camera].intrinsics.parameters.size()) + (rolling ? 1 : 0);
  }
  int pose;
  int inner;
  int from;
  int count;
};

void AddToCalibration(const CameraColumns& c, const Square& H, LandmarkTies* landmark, Accumulator* sum) {
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
}

void AddToKnots(const CameraColumns& c, const KnotColumns& columns, const Square& H, TieSlots* slots,
                LandmarkTies* landmark, Accumulator* sum) {
  for (int a = 0; a < 8; ++a) {
    sum->gradient_knots.segment<3>(sum->Local(columns[a])) += H.block<3, 1>(3 * a, kResidual);
    sum->border.block<7, 3>(c.pose, sum->Local(columns[a])) += H.block<7, 3>(kExtrinsic, 3 * a);
    sum->border.block(c.inner, sum->Local(columns[a]), c.count, 3) += H.block(c.from, 3 * a, c.count, 3);
    slots->Block(landmark, columns[a]) += H.block<3, 3>(3 * a, kPoint);
    for (int b = 0; b < 8; ++b) {
      if (columns[a] >= columns[b]) sum->AddBand(columns[a], columns[b], H.block<3, 3>(3 * a, 3 * b));
    }
  }
}

std::vector<Reprojection::Camera> Cameras(const CalibrationState& state) {
  std::vector<Reprojection::Camera> cameras;
  for (const CameraCalibration& camera : state.cameras) {
    const RigidTransform& T = camera.sensor.T_imu_sensor;
    cameras.push_back({T.rotation.toRotationMatrix(), T.translation, &camera.intrinsics});
  }
  return cameras;
}

}  // namespace

void AddLandmarks(const LinearizationPoint& at, std::size_t d, std::size_t begin, std::size_t end,
                  LandmarkTies* ties, Accumulator* sum) {
  const LandmarkSet& set = at.problem.landmarks[d];
  const SplitSpline& trajectory = at.state.drives[d].trajectory;
  const std::vector<Reprojection::Camera> cameras = Cameras(at.state);
  const bool with_knots = !at.problem.hold_trajectory;
  TieSlots slots(at.layout.knots);
  Rows rows;
  Square H;
  for (std::size_t p = begin; p < end; ++p) {
    LandmarkTies& landmark = ties[p];
    landmark.calibration = Eigen::MatrixXd::Zero(at.layout.calibration, 3);
    const PointChart chart(set.points[p]);
    const Eigen::Matrix3d J_chart = chart.Jacobian().transpose();
    for (std::size_t k = set.begin[p]; k < set.begin[p + 1]; ++k) {
      const LandmarkObservation& o = set.observations[k];
      const CameraCalibration& camera = at.state.cameras[o.camera];
      const Reprojection factor = Reprojection::Of(o.pixel, camera.intrinsics);
      const double t = factor.Time(o.time, camera.sensor.time_offset, camera.readout);
      if (!trajectory.Contains(t)) continue;
      const SplineBasis rb(trajectory.rotation.knots(), t);
      const SplineBasis pb(trajectory.position.knots(), t);
      Eigen::Vector2d residual;
      Reprojection::Jacobian J;
      double weight;
      if (!factor.Evaluate(trajectory, rb, pb, cameras[o.camera], set.points[p].position, &residual, &J)) {
        sum->cost += RobustCost(kLostSigmas, &weight);
        continue;
      }
      sum->cost += RobustCost(residual.norm() / o.sigma, &weight);
      rows.topRows<kIntrinsics>() = J.topRows<kIntrinsics>();
      rows.middleRows<kMostCameraParameters>(kIntrinsics) = J.bottomRows<kMostCameraParameters>();
      rows.middleRows<3>(kPoint) = J_chart * J.middleRows<3>(Reprojection::kPoint);
      rows.row(kResidual) = residual.transpose();
      rows *= std::sqrt(weight) / o.sigma;
      const CameraColumns columns(at.layout, at.state, o.camera);
      if (with_knots) {
        H.noalias() = rows * rows.transpose();
        AddToKnots(columns, KnotColumns(at.layout, d, rb.first, pb.first), H, &slots, &landmark, sum);
      } else {
        constexpr int kRest = kColumns - kExtrinsic;
        H.bottomRightCorner<kRest, kRest>().noalias() =
            rows.bottomRows<kRest>() * rows.bottomRows<kRest>().transpose();
      }
      AddToCalibration(columns, H, &landmark, sum);
    }
    slots.Release(landmark);
  }
}

double LandmarkCost(const LinearizationPoint& at, std::size_t d, std::size_t begin, std::size_t end) {
  const LandmarkSet& set = at.problem.landmarks[d];
  const SplitSpline& trajectory = at.state.drives[d].trajectory;
  const std::vector<Reprojection::Camera> cameras = Cameras(at.state);
  double cost = 0.0;
  for (std::size_t p = begin; p < end; ++p) {
    for (std::size_t k = set.begin[p]; k < set.begin[p + 1]; ++k) {
      const LandmarkObservation& o = set.observations[k];
      const CameraCalibration& camera = at.state.cameras[o.camera];
      const Reprojection factor = Reprojection::Of(o.pixel, camera.intrinsics);
      const double t = factor.Time(o.time, camera.sensor.time_offset, camera.readout);
      if (!trajectory.Contains(t)) continue;
      Eigen::Vector2d residual;
      const bool seen = factor.Evaluate(trajectory, SplineBasis(trajectory.rotation.knots(), t),
                                        SplineBasis(trajectory.position.knots(), t), cameras[o.camera],
                                        set.points[p].position, &residual);
      double weight;
      cost += RobustCost(seen ? residual.norm() / o.sigma : kLostSigmas, &weight);
    }
  }
  return cost;
}

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
      const LandmarkObservation& o = set.observations[k];
      const CameraCalibration& camera = state.cameras[o.camera];
      const Reprojection factor = Reprojection::Of(o.pixel, camera.intrinsics);
      const double t = factor.Time(o.time, camera.sensor.time_offset, camera.readout);
      if (!trajectory.Contains(t)) continue;
      factor.Evaluate(trajectory, SplineBasis(trajectory.rotation.knots(), t),
                      SplineBasis(trajectory.position.knots(), t), cameras[o.camera], set.points[p].position,
                      &residuals[k]);
    }
  });
  return residuals;
}

}  // namespace mlic
