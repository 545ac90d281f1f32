#include "mlic_core/imu/gravity_lever_arm.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "mlic_core/geometry/so3.h"
#include "mlic_core/geometry/symmetric_matrix.h"
#include "mlic_core/imu/pose_segments.h"
#include "mlic_core/imu/robust.h"
#include "mlic_core/imu/rotation_fit.h"
#include "mlic_core/imu/specific_force_integration.h"
#include "mlic_core/sensors/bias_prior.h"

namespace mlic {
namespace {

constexpr double kGravity = 9.81;  // m/s^2; from: definition
// from: guard, far below noise.
constexpr double kSmallestPositionSigma = 1e-6;  // m: below it robust weights would follow rounding
constexpr double kSmallestTilt = 1e-7;           // rad; from: guard, far below noise
constexpr double kNoLeverArmSigma = 10.0;        // m; from: guard, longer than a vehicle's lever arms

using Vector9d = Eigen::Matrix<double, 9, 1>;
using Matrix9d = Eigen::Matrix<double, 9, 9>;
using Matrix39d = Eigen::Matrix<double, 3, 9>;
using Vector12d = Eigen::Matrix<double, 12, 1>;
using Matrix12d = Eigen::Matrix<double, 12, 12>;

struct LeverArmState {
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();
  Eigen::Vector3d bias = Eigen::Vector3d::Zero();
  Eigen::Vector3d lever_arm = Eigen::Vector3d::Zero();
  Eigen::Quaterniond R_imu_lidar = Eigen::Quaterniond::Identity();
};

// What the IMU and the poses say of one pose of one segment; all that does not depend on the state.
struct Observation {
  double elapsed = 0.0;           // T, s
  Eigen::Vector3d position;       // of the LiDAR from that of the segment's middle, odometry frame, m
  Eigen::Matrix3d turn;           // D_k
  Eigen::Vector3d moved;          // beta_k
  Eigen::Matrix3d bias_jacobian;  // B_k
};

struct Segment {
  Eigen::Matrix3d orientation;  // R_c, of the IMU in the odometry frame
  double tilt_sigma = 0.0;      // of delta, rad
  Eigen::Matrix3d mean_turn;    // of D_k: Exp(rho) * R_imu_lidar turns R_c by Exp(-mean_turn * rho)
  std::vector<Observation> observations;
};

// The residual with p_0, v_0 and delta zero; it falls by global * step and local * (p_0, v_0, delta).
struct Row {
  Eigen::Vector3d value;
  Eigen::Matrix<double, 3, 12> global;
  Matrix39d local;
};

Row RowOf(const Segment& segment, const Observation& o, const LeverArmState& x) {
  const Eigen::Matrix3d& R = segment.orientation;
  const Eigen::Vector3d q = o.turn * x.lever_arm + o.moved - o.bias_jacobian * x.bias;
  const double half_square = 0.5 * o.elapsed * o.elapsed;
  Row row;
  row.value = o.position - R * q - half_square * x.gravity;
  row.global << half_square * Eigen::Matrix3d::Identity(), -R * o.bias_jacobian, R * o.turn,
      R * Hat(q) * segment.mean_turn;
  row.local << Eigen::Matrix3d::Identity(), o.elapsed * Eigen::Matrix3d::Identity(), -R * Hat(q);
  return row;
}

// Whitened normal equations of a step: H * step = b.
struct LeverArmSystem {
  Matrix12d H = Matrix12d::Zero();  // order: gravity, bias, lever arm, rotation
  Vector12d b = Vector12d::Zero();
  double sigma = kSmallestPositionSigma;
  double rms = 0.0;
  double inlier_share = 0.0;
};

std::vector<Segment> MakeSegments(const SpecificForceIntegration& integration,
                                  const std::vector<TimedPose>& poses, const Eigen::Quaterniond& R_imu_lidar,
                                  double time_offset) {
  std::vector<Segment> segments;
  std::vector<double> deviations;
  const GyroIntegration& gyro = integration.gyro();
  for (const PoseSegment& cut : CutSegments(poses, gyro, time_offset)) {
    const TimedPose& middle = poses[cut.Center()];
    const double center = middle.time + time_offset;
    Segment segment;
    std::vector<Eigen::Quaterniond> orientations;
    for (int k = cut.begin; k < cut.end; ++k) {
      const double time = poses[k].time + time_offset;
      const Eigen::Quaterniond turn = gyro.RotationBetween(center, time);
      orientations.push_back(poses[k].pose.rotation * R_imu_lidar.conjugate() * turn.conjugate());
      Observation o;
      o.elapsed = time - center;
      o.position = poses[k].pose.translation - middle.pose.translation;
      o.turn = turn.toRotationMatrix();
      o.moved = integration.Position(center, time);
      o.bias_jacobian = integration.PositionBiasJacobian(center, time);
      segment.observations.push_back(o);
    }
    const Eigen::Quaterniond mean = RobustMean(orientations, kSmallestTilt);
    for (const Eigen::Quaterniond& orientation : orientations)
      deviations.push_back(AngleBetween(mean, orientation));
    segment.orientation = mean.toRotationMatrix();
    segment.mean_turn.setZero();
    for (const Observation& o : segment.observations) {
      segment.mean_turn += o.turn / static_cast<double>(segment.observations.size());
    }
    segments.push_back(std::move(segment));
  }
  // The mean's own error, with half as much again for what neighbouring poses have in common.
  const double sigma = 1.5 * SigmaFromNorms(deviations);
  for (Segment& segment : segments) {
    const double count = static_cast<double>(segment.observations.size());
    segment.tilt_sigma = std::max(kSmallestTilt, sigma / std::sqrt(count));
  }
  return segments;
}

class Solver {
 public:
  // A later call with the same cuts keeps the weights.
  void SetSegments(std::vector<Segment> segments) {
    segments_ = std::move(segments);
    if (!weights_.empty()) return;
    for (const Segment& segment : segments_) weights_.emplace_back(segment.observations.size(), 1.0);
  }

  // Re-weights by the residuals at x, then linearises there.
  LeverArmSystem Linearize(const LeverArmState& x, bool redescending) {
    LeverArmSystem system;
    std::vector<std::vector<Row>> rows(segments_.size());
    std::vector<double> norms;
    for (std::size_t s = 0; s < segments_.size(); ++s) {
      for (const Observation& o : segments_[s].observations) rows[s].push_back(RowOf(segments_[s], o, x));
      const Vector9d local = SolveSymmetric(LocalSystem(rows[s], s), LocalGradient(rows[s], s));
      for (Row& row : rows[s]) norms.push_back((row.value - row.local * local).norm());
    }
    // Position and velocity take six of each segment's degrees of freedom.
    const double count = static_cast<double>(norms.size());
    const double freedom = std::max(0.2, 1.0 - 2.0 * static_cast<double>(segments_.size()) / count);
    sigma_ = system.sigma = std::max(kSmallestPositionSigma, SigmaFromNorms(norms) / std::sqrt(freedom));
    double squares = 0.0, inliers = 0.0, correlated = 0.0;
    std::size_t next = 0;
    for (std::size_t s = 0; s < segments_.size(); ++s) {
      for (std::size_t k = 0; k < rows[s].size(); ++k, ++next) {
        weights_[s][k] =
            redescending ? TukeyWeight(norms[next], sigma_) : AbsoluteWeight(norms[next], sigma_);
      }
      const Matrix9d local_system = LocalSystem(rows[s], s);
      const Vector9d local_gradient = LocalGradient(rows[s], s);
      const Vector9d local = SolveSymmetric(local_system, local_gradient);
      Eigen::MatrixXd mixed = Eigen::MatrixXd::Zero(9, 12);
      for (std::size_t k = 0; k < rows[s].size(); ++k) {
        const Row& row = rows[s][k];
        const double weight = weights_[s][k];
        mixed += weight * row.local.transpose() * row.global;
        system.H += weight * row.global.transpose() * row.global;
        system.b += weight * row.global.transpose() * row.value;
        const Eigen::Vector3d residual = row.value - row.local * local;
        if (residual.norm() > 6.0 * sigma_) continue;
        squares += residual.squaredNorm();
        inliers += 1.0;
        if (k > 0)
          correlated +=
              residual.dot(rows[s][k - 1].value - rows[s][k - 1].local * local) * weights_[s][k - 1];
      }
      system.H -= mixed.transpose() * SolveSymmetric(local_system, mixed);
      system.b -= mixed.transpose() * local;
    }
    system.inlier_share = inliers / count;
    system.rms = std::sqrt(squares / std::max(1.0, 3.0 * inliers * freedom));
    // Errors that neighbours share count less: first-order autoregressive residuals.
    const double rho = std::min(0.9, std::max(0.0, correlated / std::max(squares, 1e-300)));
    const double variance = sigma_ * sigma_ * (1.0 + rho) / (1.0 - rho);
    system.H /= variance;
    system.b /= variance;
    return system;
  }

 private:
  Matrix9d LocalSystem(const std::vector<Row>& rows, std::size_t s) const {
    Matrix9d H = Matrix9d::Identity() * 1e-9;
    const double tilt = std::max(sigma_, kSmallestPositionSigma) / segments_[s].tilt_sigma;
    H.diagonal().tail<3>().array() += tilt * tilt;
    for (std::size_t k = 0; k < rows.size(); ++k)
      H += weights_[s][k] * rows[k].local.transpose() * rows[k].local;
    return H;
  }
  Vector9d LocalGradient(const std::vector<Row>& rows, std::size_t s) const {
    Vector9d b = Vector9d::Zero();
    for (std::size_t k = 0; k < rows.size(); ++k)
      b += weights_[s][k] * rows[k].local.transpose() * rows[k].value;
    return b;
  }

  std::vector<Segment> segments_;
  std::vector<std::vector<double>> weights_;
  double sigma_ = 0.01;  // m; a first guess of the odometry's noise
};

// Columns: gravity of any length, lever arm and, with it, rotation. A bias looks like gravity of another
// length in a drive that hardly tilts, so it waits until that length is known.
Eigen::MatrixXd WithoutBias(bool with_rotation) {
  Eigen::MatrixXd basis = Eigen::MatrixXd::Zero(12, with_rotation ? 9 : 6);
  basis.topLeftCorner<3, 3>().setIdentity();
  basis.bottomRows(6).rightCols(basis.cols() - 3).setIdentity();
  return basis;
}

// Columns: the steps that keep the length of gravity to first order, then bias, lever arm and rotation.
Eigen::MatrixXd KeepingGravityLength(const Eigen::Vector3d& gravity) {
  Eigen::MatrixXd basis = Eigen::MatrixXd::Zero(12, 11);
  basis.block<3, 1>(0, 0) = gravity.unitOrthogonal();
  basis.block<3, 1>(0, 1) = gravity.normalized().cross(gravity.unitOrthogonal());
  basis.bottomRightCorner<9, 9>().setIdentity();
  return basis;
}

struct Priors {
  LeverArmGuess lever_arm;
  Eigen::Quaterniond R_imu_lidar;
  Eigen::Matrix3d rotation_information;

  // The lever arm's own prior is left out where what the data alone show is asked for.
  void AddTo(const LeverArmState& x, bool with_lever_arm, LeverArmSystem* system) const {
    const double bias_information = 1.0 / (kAccelerometerBiasSigma * kAccelerometerBiasSigma);
    system->H.diagonal().segment<3>(3).array() += bias_information;
    system->b.segment<3>(3) -= bias_information * x.bias;
    system->H.bottomRightCorner<3, 3>() += rotation_information;
    system->b.tail<3>() -=
        rotation_information * Log(Eigen::Quaterniond(x.R_imu_lidar * R_imu_lidar.conjugate()));
    if (!with_lever_arm) return;
    const Eigen::Vector3d information = lever_arm.sigma.array().square().inverse();
    system->H.diagonal().segment<3>(6) += information;
    system->b.segment<3>(6) -= information.cwiseProduct(x.lever_arm - lever_arm.p_imu_lidar);
  }
};

void Step(const Vector12d& step, LeverArmState* x) {
  x->gravity += step.head<3>();
  x->bias += step.segment<3>(3);
  x->lever_arm += step.segment<3>(6);
  x->R_imu_lidar = (ExpQuaternion(step.tail<3>()) * x->R_imu_lidar).normalized();
}

void FillResult(const LeverArmState& x, const LeverArmSystem& data, const Priors& priors,
                GravityLeverArm* result) {
  result->valid = true;
  result->gravity = x.gravity;
  result->accelerometer_bias = x.bias;
  result->p_imu_lidar = x.lever_arm;
  result->R_imu_lidar = x.R_imu_lidar;
  result->residual_rms = data.rms;
  result->inlier_share = data.inlier_share;
  const Eigen::MatrixXd basis = KeepingGravityLength(x.gravity);
  LeverArmSystem system = data;
  priors.AddTo(x, false, &system);
  // All but the lever arm is eliminated.
  const Eigen::MatrixXd H = basis.transpose() * system.H * basis;
  Eigen::MatrixXd rest(8, 8), mixed(8, 3);
  rest << H.topLeftCorner<5, 5>(), H.topRightCorner<5, 3>(), H.bottomLeftCorner<3, 5>(),
      H.bottomRightCorner<3, 3>();
  mixed << H.block<5, 3>(0, 5), H.block<3, 3>(8, 5);
  result->lever_arm_information = H.block<3, 3>(5, 5) - mixed.transpose() * SolveSymmetric(rest, mixed);

  system = data;
  priors.AddTo(x, true, &system);
  const Eigen::MatrixXd posterior = basis.transpose() * system.H * basis;
  const Eigen::MatrixXd covariance = SolveSymmetric(posterior, Eigen::MatrixXd::Identity(11, 11));
  result->accelerometer_bias_covariance = covariance.block<3, 3>(2, 2);
  result->lever_arm_covariance = covariance.block<3, 3>(5, 5);
  result->rotation_covariance = covariance.block<3, 3>(8, 8);
  const SymmetricEigen<Eigen::Dynamic> gravity(Eigen::Matrix2d(covariance.topLeftCorner<2, 2>()));
  result->gravity_direction_sigma = std::sqrt(std::max(0.0, gravity.eigenvalues()[1])) / kGravity;
}

}  // namespace

GravityLeverArm SolveGravityLeverArm(const std::vector<ImuSample>& imu, const std::vector<TimedPose>& poses,
                                     const Eigen::Quaterniond& R_imu_lidar, double time_offset,
                                     const Eigen::Vector3d& gyroscope_bias,
                                     const std::optional<LeverArmGuess>& guess,
                                     const Eigen::Matrix3d& rotation_covariance) {
  constexpr int kFreeGravityIterations = 6;    // from: guard, ends by convergence
  constexpr int kFixedRotationIterations = 3;  // from: guard, ends by convergence
  constexpr int kIterations = 40;              // from: guard, ends by convergence
  GravityLeverArm result;
  const SpecificForceIntegration integration(imu, gyroscope_bias);
  const std::vector<TimedPose> ordered = OrderedFinitePoses(poses);
  std::vector<Segment> segments = MakeSegments(integration, ordered, R_imu_lidar, time_offset);
  if (segments.empty()) {
    result.failure = "no part of the odometry of 2 s is covered by the IMU without gaps";
    return result;
  }
  Priors priors;
  priors.lever_arm =
      guess ? *guess : LeverArmGuess{Eigen::Vector3d::Zero(), Eigen::Vector3d::Constant(kNoLeverArmSigma)};
  priors.R_imu_lidar = R_imu_lidar;
  priors.rotation_information = (rotation_covariance + Eigen::Matrix3d::Identity() * 1e-14).inverse();
  LeverArmState x;
  x.lever_arm = priors.lever_arm.p_imu_lidar;
  x.R_imu_lidar = R_imu_lidar;
  Solver solver;
  solver.SetSegments(std::move(segments));
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    LeverArmSystem system = solver.Linearize(x, iteration >= kFreeGravityIterations);
    priors.AddTo(x, true, &system);
    // The rotation waits until gravity is there: its Jacobian stands on it.
    const Eigen::MatrixXd basis = iteration < kFreeGravityIterations
                                      ? WithoutBias(iteration >= kFixedRotationIterations)
                                      : KeepingGravityLength(x.gravity);
    Vector12d step =
        basis * SolveSymmetric(basis.transpose() * system.H * basis, basis.transpose() * system.b);
    step.tail<3>() *= std::min(1.0, 0.3 / (step.tail<3>().norm() + 1e-300));
    Step(step, &x);
    if (iteration + 1 >= kFreeGravityIterations) x.gravity *= kGravity / std::max(x.gravity.norm(), 1e-9);
    if (step.tail<3>().norm() > 1e-9) {
      solver.SetSegments(MakeSegments(integration, ordered, x.R_imu_lidar, time_offset));
    }
    if (iteration > kFreeGravityIterations + 2 && step.norm() < 1e-9) break;
  }
  FillResult(x, solver.Linearize(x, true), priors, &result);
  return result;
}

}  // namespace mlic
