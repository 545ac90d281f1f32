#include "ceres_reference/comparison.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "mlic_core/geometry/so3.h"
#include "mlic_core/problem/priors.h"
#include "mlic_core/problem/time_windows.h"
#include "mlic_core/sensors/imu_matrices.h"

namespace mlic::ceres_reference {
namespace {

Eigen::Matrix<double, 7, 1> Difference(const SensorCalibration& a, const SensorCalibration& b) {
  Eigen::Matrix<double, 7, 1> difference;
  difference << Log(a.T_imu_sensor.rotation * b.T_imu_sensor.rotation.conjugate()),
      a.T_imu_sensor.translation - b.T_imu_sensor.translation, a.time_offset - b.time_offset;
  return difference;
}

}  // namespace

Eigen::VectorXd CalibrationDifference(const Layout& layout, const CalibrationState& a,
                                      const CalibrationState& b) {
  Eigen::VectorXd difference = Eigen::VectorXd::Zero(layout.calibration);
  for (std::size_t i = 0; i < a.lidars.size(); ++i) {
    difference.segment<7>(Layout::Lidar(i)) = Difference(a.lidars[i], b.lidars[i]);
  }
  for (std::size_t c = 0; c < a.cameras.size(); ++c) {
    const CameraCalibration &x = a.cameras[c], &y = b.cameras[c];
    difference.segment<7>(layout.Camera(c)) = Difference(x.sensor, y.sensor);
    if (layout.Readout(c) >= 0) difference[layout.Readout(c)] = x.readout - y.readout;
    for (std::size_t i = 0; i < x.intrinsics.parameters.size(); ++i) {
      difference[layout.Intrinsics(c) + static_cast<int>(i)] =
          x.intrinsics.parameters[i] - y.intrinsics.parameters[i];
    }
  }
  for (std::size_t d = 0; d < a.drives.size(); ++d) {
    difference.segment<Layout::kOfBias>(layout.Bias(d, 0)) =
        a.drives[d].bias.knots[0] - b.drives[d].bias.knots[0];
  }
  difference[layout.gravity] = a.gravity - b.gravity;
  difference[layout.lag] = a.accelerometer_lag - b.accelerometer_lag;
  const RotationAndTriangle of_a = SplitAccelerometerMatrix(a.accelerometer_matrix),
                            of_b = SplitAccelerometerMatrix(b.accelerometer_matrix);
  difference.segment<3>(layout.alignment) = Log(Eigen::Matrix3d(of_a.rotation * of_b.rotation.transpose()));
  if (layout.matrices < 0) return difference;
  int at = layout.matrices;
  for (const Eigen::Matrix3d& apart : {Eigen::Matrix3d(of_a.triangle - of_b.triangle),
                                       Eigen::Matrix3d(a.gyroscope_matrix - b.gyroscope_matrix)}) {
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c <= r; ++c) difference[at++] = apart(r, c);
    }
  }
  return difference;
}

Eigen::MatrixXd CalibrationCovariance(const JointProblem& problem, const CalibrationState& state,
                                      const Eigen::MatrixXd& information) {
  const Layout layout(state, problem.estimate_imu_matrices);
  const std::vector<bool> free = FreeCalibration(problem, layout);
  Eigen::MatrixXd H;
  Eigen::VectorXd gradient;
  CalibrationPrior(problem, state, layout, &H, &gradient);
  H += information;
  for (int i = 0; i < H.rows(); ++i) {
    if (free[i]) continue;
    H.row(i).setZero();
    H.col(i).setZero();
    H(i, i) = 1.0;
  }
  Eigen::MatrixXd covariance = H.ldlt().solve(Eigen::MatrixXd::Identity(H.rows(), H.cols()));
  for (int i = 0; i < H.rows(); ++i) {
    if (!free[i]) covariance(i, i) = 0.0;
  }
  return covariance;
}

double LargestInSigmas(const Eigen::VectorXd& difference, const Eigen::MatrixXd& covariance) {
  double largest = 0.0;
  for (int i = 0; i < difference.size(); ++i) {
    if (covariance(i, i) <= 0.0) continue;
    largest = std::max(largest, std::abs(difference[i]) / std::sqrt(covariance(i, i)));
  }
  return largest;
}

JointProblem WithPointsCut(JointProblem problem, const CalibrationState& state) {
  for (std::size_t d = 0; d < problem.drives.size(); ++d) {
    LandmarkSet& landmarks = problem.drives[d].landmarks;
    std::vector<std::size_t> origins;
    landmarks = SplitPoints(landmarks, state, d, kLongestPointCoupling, &origins);
  }
  return problem;
}

SolveSummary ContinueSolve(int iterations, JointProblem* problem, CalibrationState* state) {
  SolveSummary summary = SolveJointProblem(*problem, iterations, CancellationToken(), state);
  PlaceLandmarks(std::move(summary.landmarks), problem);
  return summary;
}

OwnMinimum FindOwnMinimum(const JointProblem& given, const CalibrationState& start) {
  constexpr double kStill = 1e-5;  // sigmas
  constexpr int kMost = 40;
  OwnMinimum minimum{start, WithPointsCut(given, start), {}, 0.0, 0.0};
  const Layout layout(start, given.estimate_imu_matrices);
  for (int i = 0; i < kMost; ++i) {
    const CalibrationState before = minimum.state;
    const SolveSummary summary = ContinueSolve(6, &minimum.problem, &minimum.state);
    if (i == 0) minimum.first_cost = summary.first_cost;
    minimum.covariance = CalibrationCovariance(minimum.problem, minimum.state, summary.information);
    minimum.last_change =
        LargestInSigmas(CalibrationDifference(layout, minimum.state, before), minimum.covariance);
    if (minimum.last_change < kStill) break;
  }
  return minimum;
}

}  // namespace mlic::ceres_reference
