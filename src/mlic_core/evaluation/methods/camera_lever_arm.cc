#include "mlic_core/evaluation/methods/camera_lever_arm.h"

#include <algorithm>

#include "mlic_core/imu/robust.h"

namespace mlic {
namespace {

constexpr std::size_t kFewestMotions = 10;      // from: guard
constexpr double kLeastMotion = 0.05;           // m; from: guard, as AlignCameraRotation's
constexpr double kLeastSigma = 1e-4;            // rad, of a direction; from: guard, far below noise
constexpr double kNoGuessSigma = 10.0;          // m; from: guard, wider than any answer
constexpr int kConvexRounds = 5, kRounds = 20;  // of weights; from: guard, they settle in ten

// The camera's motion in the IMU's frame at its end is moved + turned * p_imu_camera, along the direction.
struct Equation {
  Eigen::Vector3d moved, direction;
  Eigen::Matrix3d turned;

  Eigen::Vector3d MotionAt(const Eigen::Vector3d& p) const { return moved + turned * p; }
  // Of a vector what is across the direction.
  Eigen::Matrix3d Across() const { return Eigen::Matrix3d::Identity() - direction * direction.transpose(); }
};

std::vector<Equation> EquationsOf(const std::vector<VisualMotion>& motions,
                                  const std::vector<const SplitSpline*>& T_map_imu,
                                  const Eigen::Quaterniond& R_imu_camera, double time_offset) {
  std::vector<Equation> equations;
  for (const VisualMotion& motion : motions) {
    const double a = motion.time_a + time_offset, b = motion.time_b + time_offset;
    const SplitSpline& trajectory = *T_map_imu[motion.drive];
    if (motion.direction.isZero() || !trajectory.Contains(a) || !trajectory.Contains(b)) continue;
    const RigidTransform T_b_a = trajectory.Pose(b).Inverse() * trajectory.Pose(a);
    equations.push_back({-T_b_a.translation, R_imu_camera * motion.direction,
                         Eigen::Matrix3d::Identity() - T_b_a.rotation.toRotationMatrix()});
  }
  return equations;
}

}  // namespace

std::optional<Eigen::Vector3d> CameraLeverArm(const std::vector<VisualMotion>& motions,
                                              const std::vector<const SplitSpline*>& T_map_imu,
                                              const Eigen::Quaterniond& R_imu_camera, double time_offset,
                                              const std::optional<ExtrinsicGuess>& guess) {
  const std::vector<Equation> equations = EquationsOf(motions, T_map_imu, R_imu_camera, time_offset);
  const Eigen::Vector3d prior = guess ? guess->T_imu_sensor.translation : Eigen::Vector3d::Zero();
  const Eigen::Vector3d prior_sigma =
      guess ? guess->sigma_translation : Eigen::Vector3d::Constant(kNoGuessSigma);
  Eigen::Vector3d p = prior;
  for (int round = 0; round < kRounds; ++round) {
    std::vector<double> angles(equations.size(), 0.0), shown;  // sines; 1 of those that go the other way
    for (std::size_t k = 0; k < equations.size(); ++k) {
      const Eigen::Vector3d motion = equations[k].MotionAt(p);
      if (motion.norm() < kLeastMotion) continue;
      const double along = motion.dot(equations[k].direction);
      angles[k] = along > 0.0 ? (equations[k].Across() * motion).norm() / motion.norm() : 1.0;
      shown.push_back(angles[k]);
    }
    if (shown.size() < kFewestMotions) return std::nullopt;
    const double sigma = std::max(kLeastSigma, SigmaFromNorms(shown));
    Eigen::Matrix3d information = prior_sigma.cwiseAbs2().cwiseInverse().asDiagonal();
    Eigen::Vector3d right = information * prior;
    for (std::size_t k = 0; k < equations.size(); ++k) {
      const double length = equations[k].MotionAt(p).norm();
      if (length < kLeastMotion) continue;
      const double weight =
          round < kConvexRounds ? AbsoluteWeight(angles[k], sigma) : TukeyWeight(angles[k], sigma);
      const Eigen::Matrix3d across =
          weight / (sigma * sigma * length * length) * equations[k].Across();  // a projector
      information += equations[k].turned.transpose() * across * equations[k].turned;
      right -= equations[k].turned.transpose() * across * equations[k].moved;
    }
    p = information.ldlt().solve(right);
  }
  return p;
}

}  // namespace mlic
