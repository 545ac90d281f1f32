#include "mlic_core/problem/landmark_terms.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mlic_core/common/parallel.h"
#include "mlic_core/factors/lidar_point.h"
#include "mlic_core/factors/reprojection.h"

namespace mlic {
namespace {

// The cost of a point that its camera cannot see any more, as if it were this many sigmas off.
constexpr double kLostSigmas = 100.0;  // from: guard, far beyond any residual

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
// in the layout as well), then the point in its chart, the drift of the clock (zero where it is not
// estimated), then the residual.
constexpr int kExtrinsic = Reprojection::kExtrinsic;         // from: structural, places of columns
constexpr int kReadout = Reprojection::kReadout;             // from: structural, places of columns
constexpr int kIntrinsics = kReadout + 1;                    // from: structural, places of columns
constexpr int kPoint = kIntrinsics + kMostCameraParameters;  // from: structural, places of columns
constexpr int kDrift = kPoint + 3;                           // from: structural, places of columns
constexpr int kResidual = kDrift + 1;                        // from: structural, places of columns
constexpr int kColumns = kResidual + 1;                      // from: structural, places of columns
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
                LandmarkCoupling* landmark, Accumulator* sum) {
  for (int a = 0; a < 8; ++a) {
    sum->gradient_knots.segment<3>(sum->Local(columns[a])) += H.block<3, 1>(3 * a, kResidual);
    sum->border.block<7, 3>(c.pose, sum->Local(columns[a])) += H.block<7, 3>(kExtrinsic, 3 * a);
    sum->border.block(c.inner, sum->Local(columns[a]), c.count, 3) += H.block(c.from, 3 * a, c.count, 3);
    if (c.drift >= 0)
      sum->border.block<1, 3>(c.drift, sum->Local(columns[a])) += H.block<1, 3>(kDrift, 3 * a);
    slots->Block(landmark, columns[a]) += H.block<3, 3>(3 * a, kPoint);
    for (int b = 0; b < 8; ++b) {
      if (columns[a] >= columns[b]) sum->AddBand(columns[a], columns[b], H.block<3, 3>(3 * a, 3 * b));
    }
  }
}

// The trajectory's splines at one time.
struct Bases {
  Bases(const SplitSpline& trajectory, double time)
      : rotation(trajectory.rotation.knots(), time), position(trajectory.position.knots(), time) {}
  SplineBasis rotation, position;
};

// The row of a LiDAR's measurement, its pose and offset in the place of the camera's.
using LidarRows = Eigen::Matrix<double, kColumns, 3>;

LidarPointResidual ResidualOf(const LidarPointObservation& observation) {
  return {observation.position, observation.sigma_along, observation.sigma_across};
}

// use(bases, rows) for the LiDAR's measurement of a point on the map that the trajectory reaches; its cost is
// added.
template <typename Use>
void WithLidarRows(const LinearizationPoint& at, std::size_t d, std::size_t p, const Eigen::Matrix3d& J_chart,
                   double* cost, const Use& use) {
  const LandmarkSet& set = at.problem.drives[d].landmarks;
  const LidarPointObservation& observation = set.lidar_points[p];
  const SensorCalibration& lidar = at.state.lidars[observation.lidar];
  const SplitSpline& trajectory = at.state.drives[d].trajectory;
  const double t = lidar.OnImuClock(observation.time, trajectory.Middle());
  if (!trajectory.Contains(t)) return;
  const Bases bases(trajectory, t);
  LidarPointResidual::Jacobian J;
  const Eigen::Vector3d residual =
      ResidualOf(observation)
          .Evaluate(trajectory, bases.rotation, bases.position, lidar, set.points[p].position, &J);
  *cost += residual.squaredNorm();
  LidarRows rows = LidarRows::Zero();
  rows.topRows<LidarPointResidual::kPoint>() = J.topRows<LidarPointResidual::kPoint>();
  rows.middleRows<3>(kPoint) = J_chart * J.middleRows<3>(LidarPointResidual::kPoint);
  rows.row(kDrift) = (observation.time - trajectory.Middle()) * rows.row(Reprojection::kTimeOffset);
  rows.row(kResidual) = residual.transpose();
  use(bases, rows);
}

void AddLidarPoint(const LinearizationPoint& at, std::size_t d, std::size_t p, const Eigen::Matrix3d& J_chart,
                   CouplingSlots* slots, LandmarkCoupling* landmark, Accumulator* sum) {
  WithLidarRows(at, d, p, J_chart, &sum->cost, [&](const Bases& bases, const LidarRows& rows) {
    const Square H = rows * rows.transpose();
    const CameraColumns columns =
        CameraColumns::OfLidar(at.layout, at.problem.drives[d].landmarks.lidar_points[p].lidar);
    if (!at.problem.fix_trajectory) {
      AddToKnots(columns, KnotColumns(at.layout, d, bases.rotation.first, bases.position.first), H, slots,
                 landmark, sum);
    }
    AddToCalibration(columns, H, landmark, sum);
  });
}

std::vector<Reprojection::Camera> Cameras(const CalibrationState& state) {
  std::vector<Reprojection::Camera> cameras;
  for (const CameraCalibration& camera : state.cameras) {
    const RigidTransform& T = camera.sensor.T_imu_sensor;
    cameras.push_back({T.rotation.toRotationMatrix(), T.translation, &camera.intrinsics});
  }
  return cameras;
}

// One observation of a landmark by a camera of the state, with its time on the IMU's clock. middle: of the
// drive.
struct CameraObservation {
  CameraObservation(const LandmarkObservation& o, const CalibrationState& state, double middle) : given(o) {
    const CameraCalibration& calibration = state.cameras[o.camera];
    factor = Reprojection::Of(o.pixel, calibration.intrinsics);
    time = factor.Time(calibration.sensor.OnImuClock(o.time, middle), calibration.readout);
  }
  // False where the camera cannot see the point: then the residual (px) stays as it is.
  bool Evaluate(const SplitSpline& trajectory, const std::vector<Reprojection::Camera>& cameras,
                const Eigen::Vector3d& point, Eigen::Vector2d* residual) const {
    const Bases bases(trajectory, time);
    return factor.Evaluate(trajectory, bases.rotation, bases.position, cameras[given.camera], point,
                           residual);
  }
  const LandmarkObservation& given;
  Reprojection factor;
  double time;
};

// The whitened rows of the cameras' observations of one drive's landmarks, one observation after the other.
class ObservationRows {
 public:
  ObservationRows(const LinearizationPoint& at, std::size_t drive)
      : at_(at),
        set_(at.problem.drives[drive].landmarks),
        trajectory_(at.state.drives[drive].trajectory),
        cameras_(Cameras(at.state)) {}

  // use(observation, bases, rows) for each observation of landmark p that the trajectory reaches and the
  // camera can see; all costs are added.
  template <typename Use>
  void ForEach(std::size_t p, const Eigen::Matrix3d& J_chart, double* cost, const Use& use) {
    for (std::size_t k = set_.begin[p]; k < set_.begin[p + 1]; ++k) {
      const CameraObservation observation(set_.observations[k], at_.state, trajectory_.Middle());
      if (!trajectory_.Contains(observation.time)) continue;
      const Bases bases(trajectory_, observation.time);
      if (Fill(observation, bases, set_.points[p].position, J_chart, cost)) use(observation, bases, rows_);
    }
  }

 private:
  // The rows of one observation by its sigma and the robust loss's weight, whose cost is added. False where
  // the camera cannot see the point.
  bool Fill(const CameraObservation& observation, const Bases& bases, const Eigen::Vector3d& point,
            const Eigen::Matrix3d& J_chart, double* cost) {
    const LandmarkObservation& o = observation.given;
    Eigen::Vector2d residual;
    Reprojection::Jacobian J;
    double weight;
    if (!observation.factor.Evaluate(trajectory_, bases.rotation, bases.position, cameras_[o.camera], point,
                                     &residual, &J)) {
      *cost += RobustCost(kLostSigmas, &weight);
      return false;
    }
    const Eigen::Matrix2d shape = o.shape.cast<double>();
    residual = shape * residual;
    *cost += RobustCost(residual.norm() / o.sigma, &weight);
    rows_.topRows<kIntrinsics>() = J.topRows<kIntrinsics>();
    rows_.middleRows<kMostCameraParameters>(kIntrinsics) = J.bottomRows<kMostCameraParameters>();
    rows_.middleRows<3>(kPoint) = J_chart * J.middleRows<3>(Reprojection::kPoint);
    rows_.row(kDrift) = (o.time - trajectory_.Middle()) * rows_.row(Reprojection::kTimeOffset);
    rows_ *= shape.transpose();
    rows_.row(kResidual) = residual.transpose();
    rows_ *= std::sqrt(weight) / o.sigma;
    return true;
  }

  const LinearizationPoint& at_;
  const LandmarkSet& set_;
  const SplitSpline& trajectory_;
  std::vector<Reprojection::Camera> cameras_;
  Rows rows_;
};

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
  if (before.cost < equations.cost) {
    equations = before;
  } else {
    *point = moved_to;
  }
  double damping = 1e-9;  // from: guard, directions that no observation shows
  for (int i = 0; i < kMost; ++i) {
    Eigen::Matrix3d H = equations.information;
    H.diagonal() *= 1.0 + damping;
    const Eigen::Vector3d step = -H.ldlt().solve(equations.gradient);
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
                   &landmark, sum);
      } else {
        constexpr int kRest = kColumns - kExtrinsic;  // from: structural, places of columns
        H.bottomRightCorner<kRest, kRest>().noalias() =
            rows.bottomRows<kRest>() * rows.bottomRows<kRest>().transpose();
      }
      AddToCalibration(columns, H, &landmark, sum);
    };
    observations.ForEach(p, J_chart, &sum->cost, add);
    if (set.IsOnMap(p)) AddLidarPoint(at, d, p, J_chart, &slots, &landmark, sum);
    slots.Release(landmark);
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
