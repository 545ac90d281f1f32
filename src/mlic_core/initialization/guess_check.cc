#include "mlic_core/initialization/guess_check.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "mlic_core/geometry/so3.h"

namespace mlic {
namespace {

struct Distance {
  double angle = 0.0;    // rad
  double length = 0.0;   // m
  double sigmas = 0.0;   // of the guess, about or along the worst axis
  double squared = 0.0;  // sigmas, of all axes together
};

Distance FromGuess(const ExtrinsicGuess& guess, const RigidTransform& found) {
  const RigidTransform& given = guess.T_imu_sensor;
  const Eigen::Vector3d turn = Log(Eigen::Quaterniond(found.rotation * given.rotation.conjugate()));
  const Eigen::Vector3d shift = found.translation - given.translation;
  const Eigen::Vector3d turned = turn.cwiseQuotient(guess.sigma_rotation);
  const Eigen::Vector3d shifted = shift.cwiseQuotient(guess.sigma_translation);
  return {turn.norm(), shift.norm(), std::max(turned.cwiseAbs().maxCoeff(), shifted.cwiseAbs().maxCoeff()),
          turned.squaredNorm() + shifted.squaredNorm()};
}

}  // namespace

bool IsLostFromGuess(const LidarConfig& config, const RigidTransform& T_imu_lidar) {
  constexpr double kNear = 2.0;  // from: derivation, 5 % of normal errors lie beyond
  return !config.guess || FromGuess(*config.guess, T_imu_lidar).sigmas > kNear;
}

std::string WhyRejected(const LidarConfig& config) {
  return config.name + ": its odometry does not agree with the gyroscope and " +
         (config.guess
              ? "its planes do not tie it to the others from the given T_imu_sensor; give a better one"
              : "the rig file gives no T_imu_sensor to start from; give one") +
         ", or leave it out by enabled: false";
}

double SigmasFromGuess(const ExtrinsicGuess& guess, const RigidTransform& T_imu_sensor) {
  return FromGuess(guess, T_imu_sensor).sigmas;
}

bool ContradictsGuess(const ExtrinsicGuess& guess, const RigidTransform& T_imu_sensor) {
  return FromGuess(guess, T_imu_sensor).sigmas > kFarFromGuess;
}

double SigmasOfExchange(const ExtrinsicGuess& guess_a, const RigidTransform& T_imu_a,
                        const ExtrinsicGuess& guess_b, const RigidTransform& T_imu_b) {
  const Distance a_at_b = FromGuess(guess_b, T_imu_a), b_at_a = FromGuess(guess_a, T_imu_b);
  if (std::max(a_at_b.sigmas, b_at_a.sigmas) > kFarFromGuess) return 0.0;
  const double own = FromGuess(guess_a, T_imu_a).squared + FromGuess(guess_b, T_imu_b).squared;
  return std::sqrt(std::max(0.0, own - a_at_b.squared - b_at_a.squared));
}

std::string DescribeDistance(const ExtrinsicGuess& guess, const RigidTransform& T_imu_sensor) {
  const Distance distance = FromGuess(guess, T_imu_sensor);
  char text[200];
  std::snprintf(text, sizeof(text), "%.1f deg and %.2f m from the given T_imu_sensor, %.0f of its sigmas",
                distance.angle * 180.0 / M_PI, distance.length, distance.sigmas);
  return text;
}

}  // namespace mlic
