#pragma once

#include <cmath>
#include <vector>

#include "mlic_core/factors/lidar_point.h"
#include "mlic_core/factors/reprojection.h"
#include "mlic_core/problem/linear_terms.h"

namespace mlic::landmark_rows {

// The rows of the observations of point landmarks, for landmark_terms.cc and settle_points.cc.

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

// The trajectory's splines at one time.
struct Bases {
  Bases(const SplitSpline& trajectory, double time)
      : rotation(trajectory.rotation.knots(), time), position(trajectory.position.knots(), time) {}
  SplineBasis rotation, position;
};

// The row of a LiDAR's measurement, its pose and offset in the place of the camera's.
using LidarRows = Eigen::Matrix<double, kColumns, 3>;

inline LidarPointResidual ResidualOf(const LidarPointObservation& observation) {
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

inline std::vector<Reprojection::Camera> Cameras(const CalibrationState& state) {
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

}  // namespace mlic::landmark_rows
