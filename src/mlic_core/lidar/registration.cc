#include "mlic_core/lidar/registration.h"

#include <algorithm>
#include <cmath>

#include "mlic_core/geometry/so3.h"
#include "mlic_core/geometry/symmetric_matrix.h"

namespace mlic {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector12d = Eigen::Matrix<double, 12, 1>;
using Matrix12d = Eigen::Matrix<double, 12, 12>;

// Where the parameters stand.
constexpr int kRotation = 0, kTranslation = 3, kAngularVelocity = 6, kLinearVelocity = 9;  // from: structural

// Errors of neighbouring points are alike (the plane's, the motion model's): so many count as one independent
// point against the prior. Without it the velocity gives way to them and the scan is bent.
constexpr double kCorrelatedPoints = 200.0;  // from: measured, drift of simulated drives by hand and car

// rad/s: of the change of the mean rate from scan to scan. Much smaller changes are not believed, or their
// noise would bend the scans.
constexpr double kRateNoise = 0.05;  // from: measured, drift of simulated drives by hand and car

constexpr int kMostIterations = 25;         // from: guard, ends by convergence
constexpr double kSmallRotation = 5e-5;     // rad; from: guard, far below noise
constexpr double kSmallTranslation = 5e-4;  // m; from: guard, far below noise
constexpr std::size_t kFewPoints = 1500;    // that are enough to get near; from: guard, time

// Normal equations over (rotation, translation, angular velocity, linear velocity) of small right
// perturbations in the LiDAR's frame. The Jacobian to the velocity is s times that to the pose, so that three
// moments in s make the whole.
struct NormalEquations {
  Matrix6d hessian[3];   // times s^0, s^1, s^2; lower triangle
  Vector6d gradient[2];  // times s^0, s^1
  double weighted_squares = 0.0;
  double weights = 0.0;

  NormalEquations() {
    for (Matrix6d& m : hessian) m.setZero();
    for (Vector6d& v : gradient) v.setZero();
  }

  // direction: of the residual, in the LiDAR's frame.
  void Add(const Eigen::Vector3d& point, const Eigen::Vector3d& direction, double residual, double s,
           double weight) {
    Vector6d jacobian;
    jacobian << point.cross(direction), direction;
    const Vector6d weighted = weight * jacobian;
    const double s_squared = s * s;
    for (int column = 0; column < 6; ++column) {
      for (int row = column; row < 6; ++row) {
        const double product = weighted[row] * jacobian[column];
        hessian[0](row, column) += product;
        hessian[1](row, column) += s * product;
        hessian[2](row, column) += s_squared * product;
      }
    }
    gradient[0] += residual * weighted;
    gradient[1] += (s * residual) * weighted;
  }

  void Expand(Matrix12d* full, Vector12d* right_side) const {
    const Matrix6d cross = hessian[1].selfadjointView<Eigen::Lower>();
    full->topLeftCorner<6, 6>() = hessian[0].selfadjointView<Eigen::Lower>();
    full->topRightCorner<6, 6>() = cross;
    full->bottomLeftCorner<6, 6>() = cross;
    full->bottomRightCorner<6, 6>() = hessian[2].selfadjointView<Eigen::Lower>();
    right_side->head<6>() = -gradient[0];
    right_side->tail<6>() = -gradient[1];
  }
};

double GemanMcClure(double squared_residual, double squared_width) {
  const double w = squared_width / (squared_width + squared_residual);
  return w * w;
}

NormalEquations MatchPoints(const std::vector<TimedPoint>& points, std::size_t stride,
                            const VoxelHashMap& map, const RigidTransform& pose, const ScanMotion& motion,
                            double width, double noise) {
  NormalEquations equations;
  const Eigen::Matrix3d rotation = pose.rotation.toRotationMatrix();
  const double squared_width = width * width;
  for (std::size_t i = 0; i < points.size(); i += stride) {
    const double s = points[i].time;
    const Eigen::Vector3d in_lidar = motion.ToMiddle(points[i].position, s);
    const Eigen::Vector3d in_odom = rotation * in_lidar + pose.translation;
    const Surface* surface = map.Find(in_odom);
    if (surface == nullptr) continue;
    const Eigen::Vector3d difference = in_odom - surface->mean;
    if (surface->kind == Surface::Kind::kPlane) {
      const double residual = surface->normal.dot(difference);
      if (std::abs(residual) > 3.0 * width) continue;
      const double kernel = GemanMcClure(residual * residual, squared_width);
      const double variance = kCorrelatedPoints * (surface->variance + noise * noise);
      equations.Add(in_lidar, rotation.transpose() * surface->normal, residual, s, kernel / variance);
      equations.weighted_squares += kernel * residual * residual;
      equations.weights += kernel;
    } else {
      for (int axis = 0; axis < 3; ++axis) {
        const Eigen::Vector3d direction = surface->axes.col(axis);
        const double residual = direction.dot(difference);
        const double kernel = GemanMcClure(residual * residual, squared_width + surface->variances[axis]);
        equations.Add(in_lidar, rotation.transpose() * direction, residual, s,
                      kernel / (3.0 * kCorrelatedPoints * (surface->variances[axis] + noise * noise)));
      }
    }
  }
  return equations;
}

// The part factor * I of a Jacobian that belongs to the three parameters from `block` on.
struct ScaledBlock {
  int block;
  double factor;
};

// Adds |residual / sigma|^2, the residual's Jacobian consisting of `first` and `second`.
void AddPrior(const Eigen::Vector3d& residual, double sigma, const ScaledBlock& first,
              const ScaledBlock& second, Matrix12d* hessian, Vector12d* right_side) {
  const ScaledBlock parts[2] = {first, second};
  const double information = 1.0 / (sigma * sigma);
  for (const ScaledBlock& a : parts) {
    right_side->segment<3>(a.block) -= information * a.factor * residual;
    for (const ScaledBlock& b : parts) {
      hessian->block<3, 3>(a.block, b.block).diagonal().array() += information * a.factor * b.factor;
    }
  }
}

void AddMotionPrior(const MotionPrior& prior, const MotionState& state, Matrix12d* hessian,
                    Vector12d* right_side) {
  const RigidTransform& pose = state.pose;
  const Eigen::Quaterniond to_lidar = pose.rotation.conjugate();
  const MeanVelocity mean = VelocityBetween(prior.previous, pose, prior.interval);
  const double gain = (1.0 + prior.extrapolation) / prior.interval;

  AddPrior(Log(prior.predicted.pose.rotation.conjugate() * pose.rotation), prior.sigma_rotation,
           {kRotation, 1.0}, {kAngularVelocity, 0.0}, hessian, right_side);
  AddPrior(to_lidar * (pose.translation - prior.predicted.pose.translation), prior.sigma_translation,
           {kTranslation, 1.0}, {kLinearVelocity, 0.0}, hessian, right_side);
  const Eigen::Vector3d angular =
      mean.angular + prior.extrapolation * (mean.angular - prior.velocity_before.angular);
  AddPrior(state.twist.angular - angular, prior.sigma_angular_velocity, {kRotation, -gain},
           {kAngularVelocity, 1.0}, hessian, right_side);
  const Eigen::Vector3d linear =
      mean.linear + (prior.velocity_gain
                         ? *prior.velocity_gain
                         : prior.extrapolation * (mean.linear - prior.velocity_before.linear));
  const double linear_gain = prior.velocity_gain ? 1.0 / prior.interval : gain;
  AddPrior(state.twist.linear - to_lidar * linear, prior.sigma_linear_velocity, {kTranslation, -linear_gain},
           {kLinearVelocity, 1.0}, hessian, right_side);
}

void Update(const Vector12d& step, MotionState* state) {
  state->pose.translation += state->pose.rotation * step.segment<3>(kTranslation);
  state->pose.rotation = (state->pose.rotation * ExpQuaternion(step.segment<3>(kRotation))).normalized();
  state->twist.angular += step.segment<3>(kAngularVelocity);
  state->twist.linear += step.segment<3>(kLinearVelocity);
}

}  // namespace

MeanVelocity VelocityBetween(const RigidTransform& from, const RigidTransform& to, double interval) {
  return {Log(from.rotation.conjugate() * to.rotation) / interval,
          (to.translation - from.translation) / interval};
}

ScanMotion MotionDuring(const MotionState& state, const MotionPrior& prior, double half_span) {
  const MeanVelocity mean = VelocityBetween(prior.previous, state.pose, prior.interval);
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();
  if (prior.extrapolation > 0.0) {
    const Eigen::Vector3d change = 2.0 * prior.extrapolation * (mean.angular - prior.velocity_before.angular);
    const double square = change.squaredNorm();
    acceleration = square / (square + kRateNoise * kRateNoise) / prior.interval * change;
  }
  ScanMotion motion =
      prior.rotation != nullptr ? *prior.rotation : ScanMotion(state.twist, acceleration, half_span);
  motion.SetLinear(state.twist.linear);
  return motion;
}

RegistrationResult RegisterScan(const std::vector<TimedPoint>& points, double half_span,
                                const VoxelHashMap& map, const MotionPrior& prior, double search_width,
                                double noise) {
  RegistrationResult result;
  result.state = prior.predicted;
  std::size_t stride = std::max<std::size_t>(1, points.size() / kFewPoints);
  const double final_width = 3.0 * noise;
  double width = std::max(search_width, final_width);
  for (int iteration = 0; iteration < kMostIterations; ++iteration) {
    const ScanMotion motion = MotionDuring(result.state, prior, half_span);
    const NormalEquations equations =
        MatchPoints(points, stride, map, result.state.pose, motion, width, noise);
    Matrix12d hessian;
    Vector12d right_side;
    equations.Expand(&hessian, &right_side);
    AddMotionPrior(prior, result.state, &hessian, &right_side);
    const Vector12d step = SolveSymmetric(hessian, right_side);
    if (!step.allFinite()) break;
    Update(step, &result.state);
    result.residual_rms =
        equations.weights > 0.0 ? std::sqrt(equations.weighted_squares / equations.weights) : 0.0;
    const double scale = stride > 1 ? 10.0 : 1.0;
    const bool settled = step.head<3>().norm() < scale * kSmallRotation &&
                         step.segment<3>(3).norm() < scale * kSmallTranslation && width == final_width;
    if (settled && stride == 1) break;
    if (settled) stride = 1;
    width = std::max(final_width, 0.5 * width);
  }
  return result;
}

}  // namespace mlic
