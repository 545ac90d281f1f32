#include "mlic_core/problem/imu_terms.h"

#include <cmath>
#include <optional>

#include "mlic_core/factors/gauge.h"
#include "mlic_core/factors/imu_residual.h"
#include "mlic_core/factors/pose.h"

namespace mlic {

namespace {

Eigen::Matrix<double, 6, 1> ImuSigmaAt(const DriveTerms& terms, double time) {
  const ImuSigma at = terms.imu_sigma.At(time);
  Eigen::Matrix<double, 6, 1> sigma;
  sigma << at.gyroscope, at.accelerometer;
  return sigma;
}

// Robust against shocks only: beyond 4 sigma.
double ImuComponentCost(double whitened, double* weight) { return RobustCost(0.5 * whitened, weight) * 4.0; }

PoseResidual ResidualOf(const PoseObservations& observed, const TimedPose& pose) {
  return {pose.pose, observed.sigma_rotation, observed.sigma_translation};
}

// The calibration that samples touch, after their control points: of ImuResidual's columns those from kBias
// on, with one more set of biases behind where these wander.
class ImuColumns {
 public:
  ImuColumns(const LinearizationPoint& at, std::size_t drive)
      : layout_(at.layout), course_(at.state.drives[drive].bias), drive_(drive) {
    for (int i = 0; i < Layout::kOfBias; ++i) indices_.push_back(layout_.Bias(drive, 0) + i);
    indices_.push_back(layout_.gravity);
    indices_.push_back(layout_.lag);
    for (int i = 0; i < 3; ++i) indices_.push_back(layout_.alignment + i);
    for (int i = 0; i < Layout::kOfMatrices && layout_.matrices >= 0; ++i) {
      indices_.push_back(layout_.matrices + i);
    }
    of_residual_ = ImuResidual::kBias + static_cast<int>(indices_.size());
    if (course_.IsConstant()) return;
    for (int i = 0; i < Layout::kOfBias; ++i) indices_.push_back(layout_.Bias(drive, 1) + i);
  }

  // For a sample at a time, until the next call.
  void MoveTo(double time) {
    if (course_.IsConstant()) return;
    place_ = course_.At(time);
    for (int i = 0; i < Layout::kOfBias; ++i) {
      indices_[i] = layout_.Bias(drive_, place_.knot) + i;
      indices_[indices_.size() - Layout::kOfBias + i] = layout_.Bias(drive_, place_.knot + 1) + i;
    }
  }
  const std::vector<int>& Indices() const { return indices_; }

  // The rows of AddRows.
  void Fill(const ImuResidual::Jacobian& J, Eigen::Matrix<double, Eigen::Dynamic, 6>* rows) const {
    rows->resize(ImuResidual::kBias + static_cast<Eigen::Index>(indices_.size()), Eigen::NoChange);
    rows->topRows(of_residual_) = J.topRows(of_residual_);
    if (course_.IsConstant()) return;
    const auto of_bias = J.middleRows<Layout::kOfBias>(ImuResidual::kBias);
    rows->middleRows<Layout::kOfBias>(ImuResidual::kBias) = (1.0 - place_.share) * of_bias;
    rows->bottomRows<Layout::kOfBias>() = place_.share * of_bias;
  }

 private:
  const Layout& layout_;
  const BiasCourse& course_;
  std::size_t drive_;
  std::vector<int> indices_;
  int of_residual_;
  BiasCourse::Place place_{0, 0.0};
};

// Where in the calibration the rotation of a LiDAR stands that sees planes; none if no LiDAR does. Points of
// cameras are as free to follow as the trajectory: with a camera's yaw fixed, a car's first steps end 30 cm
// off (camera_imu_test), with the IMU's not.
std::optional<int> LidarOfMap(const LinearizationPoint& at, std::size_t d) {
  const std::vector<PlaneObservation>& observations = at.problem.drives[d].planes.observations;
  if (observations.empty()) return std::nullopt;
  return Layout::Lidar(observations[0].lidar);
}

// The loss of the whole pose, so that a lost scan has little say.
double WholePoseCost(const Eigen::Matrix<double, 6, 1>& r, double* weight) {
  return RobustCost(r.norm() / std::sqrt(6.0), weight) * 6.0;
}

}  // namespace

std::pair<std::size_t, std::size_t> ImuPart(const LinearizationPoint& at, std::size_t drive,
                                            std::size_t chunk) {
  const std::size_t samples = at.problem.dataset->drives[drive].imu.size();
  return {samples * chunk / kLinearizationChunks, samples * (chunk + 1) / kLinearizationChunks};
}

void AddImu(const LinearizationPoint& at, std::size_t d, std::size_t chunk, Accumulator* sum) {
  const SplitSpline& trajectory = at.state.drives[d].trajectory;
  const Eigen::Vector3d gravity = at.state.Gravity();
  const auto& samples = at.problem.dataset->drives[d].imu;
  ImuColumns calibration(at, d);
  const auto [begin, end] = ImuPart(at, d, chunk);
  ImuResidual::Jacobian J;
  Eigen::Matrix<double, Eigen::Dynamic, 6> rows;
  for (std::size_t k = begin; k < end; ++k) {
    if (!trajectory.Contains(samples[k].time)) continue;
    const ImuCalibration imu = at.state.Imu(d, samples[k].time);
    const ImuBases bases(trajectory, samples[k].time, imu.accelerometer_lag);
    Eigen::Matrix<double, 6, 1> r = ImuResidual::Evaluate(trajectory, bases, imu, gravity, samples[k], &J);
    ImuResidual::TurnOne(at.state.accelerometer_axes, &J);
    const Eigen::Matrix<double, 6, 1> sigma = ImuSigmaAt(at.problem.drives[d], samples[k].time);
    for (int i = 0; i < 6; ++i) {
      double weight;
      sum->cost += ImuComponentCost(r[i] / sigma[i], &weight);
      const double scale = std::sqrt(weight) / sigma[i];
      J.col(i) *= scale;
      r[i] *= scale;
    }
    const KnotColumns of_force(at.layout, d, bases.rotation.first, bases.position.first);
    calibration.MoveTo(samples[k].time);
    calibration.Fill(J, &rows);
    if (bases.rates.first == bases.rotation.first) {
      AddRows(of_force, calibration.Indices(), rows, r, sum);
      continue;
    }
    // Rates have no position: any of the same time will do.
    const SplineBasis position(trajectory.position.knots(), samples[k].time);
    const KnotColumns of_rates(at.layout, d, bases.rates.first, position.first);
    AddRows(of_rates, calibration.Indices(), rows.leftCols<3>(), r.head<3>(), sum);
    AddRows(of_force, calibration.Indices(), rows.rightCols<3>(), r.tail<3>(), sum);
  }
}

double ImuCost(const LinearizationPoint& at, std::size_t d, std::size_t chunk) {
  const SplitSpline& trajectory = at.state.drives[d].trajectory;
  const auto& samples = at.problem.dataset->drives[d].imu;
  const auto [begin, end] = ImuPart(at, d, chunk);
  double cost = 0.0;
  for (std::size_t k = begin; k < end; ++k) {
    if (!trajectory.Contains(samples[k].time)) continue;
    const ImuCalibration imu = at.state.Imu(d, samples[k].time);
    const ImuBases bases(trajectory, samples[k].time, imu.accelerometer_lag);
    const Eigen::Matrix<double, 6, 1> r =
        ImuResidual::Evaluate(trajectory, bases, imu, at.state.Gravity(), samples[k], nullptr);
    const Eigen::Matrix<double, 6, 1> sigma = ImuSigmaAt(at.problem.drives[d], samples[k].time);
    double weight;
    for (int i = 0; i < 6; ++i) cost += ImuComponentCost(r[i] / sigma[i], &weight);
  }
  return cost;
}

void AddPoses(const LinearizationPoint& at, std::size_t d, Accumulator* sum) {
  const SplitSpline& trajectory = at.state.drives[d].trajectory;
  const PoseObservations& observed = at.problem.drives[d].poses;
  for (const TimedPose& pose : observed.T_map_imu) {
    if (!trajectory.Contains(pose.time)) continue;
    const SplineBasis rb(trajectory.rotation.knots(), pose.time);
    const SplineBasis pb(trajectory.position.knots(), pose.time);
    PoseResidual::Jacobian rows;
    Eigen::Matrix<double, 6, 1> r = ResidualOf(observed, pose).Evaluate(trajectory, rb, pb, &rows);
    double weight;
    sum->cost += WholePoseCost(r, &weight);
    rows *= std::sqrt(weight);
    r *= std::sqrt(weight);
    AddRows(KnotColumns(at.layout, d, rb.first, pb.first), {}, rows, r, sum);
  }
}

double PoseCost(const LinearizationPoint& at, std::size_t d) {
  const SplitSpline& trajectory = at.state.drives[d].trajectory;
  double cost = 0.0, weight;
  const PoseObservations& observed = at.problem.drives[d].poses;
  for (const TimedPose& pose : observed.T_map_imu) {
    if (!trajectory.Contains(pose.time)) continue;
    const SplineBasis rb(trajectory.rotation.knots(), pose.time);
    const SplineBasis pb(trajectory.position.knots(), pose.time);
    cost += WholePoseCost(ResidualOf(observed, pose).Evaluate(trajectory, rb, pb), &weight);
  }
  return cost;
}

void AddGauge(const LinearizationPoint& at, std::size_t d, Accumulator* sum) {
  const SplitSpline& trajectory = at.state.drives[d].trajectory;
  const double t = trajectory.Start();
  const SplineBasis rb(trajectory.rotation.knots(), t);
  const SplineBasis pb(trajectory.position.knots(), t);
  const GaugeResidual::Jacobian rows = GaugeResidual::JacobianAtZero(trajectory, rb, pb);
  const KnotColumns columns(at.layout, d, rb.first, pb.first);
  const Eigen::Vector4d r = Eigen::Vector4d::Zero();
  if (const std::optional<int> lidar = LidarOfMap(at, d)) {
    AddRows(columns, {*lidar, *lidar + 1, *lidar + 2}, rows, r, sum);
  } else {
    AddRows(columns, {}, rows.topRows<GaugeResidual::kSensor>().eval(), r, sum);
  }
  // Control points near the ends of a span have next to no data; a little keeps them from wandering.
  sum->band.row(0).array() += 1e-6;
}

ImuResiduals EvaluateImuResiduals(const Dataset& dataset, const CalibrationState& state, std::size_t drive) {
  const SplitSpline& trajectory = state.drives[drive].trajectory;
  ImuResiduals residuals;
  for (const ImuSample& sample : dataset.drives[drive].imu) {
    if (!trajectory.Contains(sample.time)) continue;
    residuals.times.push_back(sample.time);
    const ImuCalibration imu = state.Imu(drive, sample.time);
    const ImuBases bases(trajectory, sample.time, imu.accelerometer_lag);
    residuals.values.push_back(
        ImuResidual::Evaluate(trajectory, bases, imu, state.Gravity(), sample, nullptr));
  }
  return residuals;
}

}  // namespace mlic
