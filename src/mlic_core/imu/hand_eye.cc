#include "mlic_core/imu/hand_eye.h"

#include <ceres/autodiff_cost_function.h>
#include <ceres/rotation.h>

#include <algorithm>
#include <cmath>

#include "mlic_core/geometry/so3.h"
#include "mlic_core/geometry/symmetric_matrix.h"
#include "mlic_core/imu/hand_eye_rotation.h"
#include "mlic_core/imu/robust.h"
#include "mlic_core/sensors/observability_limits.h"
#include "mlic_core/solver/small_fit.h"

namespace mlic {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

constexpr double kNoGuessSigma = 10.0;  // rad, m; from: guard, wider than any answer
constexpr int kConvexRounds = 5;        // of weights, before the redescending ones; from: guard
constexpr int kRoundsOfAStart = 8;      // from: guard, enough to tell a wrong start from a right one
constexpr int kMostRounds = 40;         // from: guard, ends by kSettled
constexpr int kStepsInARound = 3;       // from: guard, weights change by more than further steps would
constexpr double kSettled = 1e-12;      // rad + m; from: guard, rounding

// Log of a unit quaternion, for doubles and for Ceres' dual numbers.
template <typename T>
Eigen::Matrix<T, 3, 1> LogOf(const Eigen::Quaternion<T>& q) {
  const T wxyz[4] = {q.w(), q.x(), q.y(), q.z()};
  Eigen::Matrix<T, 3, 1> log;
  ceres::QuaternionToAngleAxis(wxyz, log.data());
  return log;
}

struct RotationEquation {
  const RelativeMotion& motion;
  const double& weight;

  template <typename T>
  Eigen::Matrix<T, 3, 1> Error(const Eigen::Quaternion<T>& R) const {
    const Eigen::Quaternion<T> carried = R * motion.lidar.rotation.cast<T>() * R.conjugate();
    return LogOf(Eigen::Quaternion<T>(motion.imu.rotation.conjugate().cast<T>() * carried));
  }
  template <typename T>
  bool operator()(const T* rotation, T* r) const {
    Eigen::Map<Eigen::Matrix<T, 3, 1>> to(r);
    to = T(weight) * Error(Eigen::Quaternion<T>(rotation));
    return true;
  }
};

struct TranslationEquation {
  const RelativeMotion& motion;
  const double& weight;

  template <typename T>
  Eigen::Matrix<T, 3, 1> Error(const Eigen::Quaternion<T>& R, const Eigen::Matrix<T, 3, 1>& p) const {
    return motion.imu.rotation.cast<T>() * p - p - R * motion.lidar.translation.cast<T>() +
           motion.imu.translation.cast<T>();
  }
  template <typename T>
  bool operator()(const T* rotation, const T* translation, T* r) const {
    Eigen::Map<Eigen::Matrix<T, 3, 1>> to(r);
    to = T(weight) * Error(Eigen::Quaternion<T>(rotation), Eigen::Matrix<T, 3, 1>(translation));
    return true;
  }
};

struct Prior {
  RigidTransform T_imu_lidar;
  Eigen::Vector3d sigma_rotation = Eigen::Vector3d::Constant(kNoGuessSigma);
  Eigen::Vector3d sigma_translation = Eigen::Vector3d::Constant(kNoGuessSigma);

  explicit Prior(const std::optional<ExtrinsicGuess>& guess) {
    if (!guess) return;
    T_imu_lidar = guess->T_imu_sensor;
    sigma_rotation = guess->sigma_rotation;
    sigma_translation = guess->sigma_translation;
  }

  template <typename T>
  bool operator()(const T* rotation, const T* translation, T* r) const {
    Eigen::Map<Eigen::Matrix<T, 6, 1>> to(r);
    const Eigen::Quaternion<T> turn =
        Eigen::Quaternion<T>(rotation) * T_imu_lidar.rotation.conjugate().cast<T>();
    to << LogOf(turn).cwiseQuotient(sigma_rotation.cast<T>()),
        (Eigen::Matrix<T, 3, 1>(translation) - T_imu_lidar.translation.cast<T>())
            .cwiseQuotient(sigma_translation.cast<T>());
    return true;
  }
};

// What the equations of each motion are multiplied by, from how well it fits.
struct Weights {
  std::vector<double> rotation, translation;
  double rotation_scale = 1.0;
  double translation_scale = 1.0;
  double inlier_share = 0.0;
  double cost = 0.0;  // robust, to compare starts
  // The weights of good residuals lie somewhat below 1, which takes nothing from the precision: the weighted
  // information times this is the information.
  double information_factor = 1.0;
};

class Fit {
 public:
  // overlap: of the motions; see SolveHandEye.
  Fit(const std::vector<RelativeMotion>& motions, const Prior& prior, double overlap)
      : motions_(motions), prior_(prior), overlap_(overlap) {}

  // Iteratively re-weighted from a rotation, convex weights first.
  RigidTransform Refine(const Eigen::Quaterniond& rotation, int rounds);

  Weights Weigh(const RigidTransform& T, bool redescending) const;

  void FillResult(const RigidTransform& T, HandEyeResult* result);

 private:
  void AddRotations(SmallFit* fit) {
    for (std::size_t i = 0; i < motions_.size(); ++i) {
      using Cost = ceres::AutoDiffCostFunction<RotationEquation, 3, 4>;
      fit->Add(new Cost(new RotationEquation{motions_[i], weights_.rotation[i]}), {Rotation()});
    }
  }
  void AddTranslations(SmallFit* fit) {
    for (std::size_t i = 0; i < motions_.size(); ++i) {
      using Cost = ceres::AutoDiffCostFunction<TranslationEquation, 3, 4, 3>;
      fit->Add(new Cost(new TranslationEquation{motions_[i], weights_.translation[i]}),
               {Rotation(), Translation()});
    }
  }
  void AddPrior(SmallFit* fit) {
    fit->Add(new ceres::AutoDiffCostFunction<Prior, 6, 4, 3>(new Prior(prior_)), {Rotation(), Translation()});
  }
  double* Rotation() { return T_.rotation.coeffs().data(); }
  double* Translation() { return T_.translation.data(); }

  const std::vector<RelativeMotion>& motions_;
  const Prior& prior_;
  const double overlap_;
  RigidTransform T_;
  Weights weights_;
};

Weights Fit::Weigh(const RigidTransform& T, bool redescending) const {
  std::vector<double> rotation_norms, translation_norms;
  const double unweighted = 1.0;
  for (const RelativeMotion& motion : motions_) {
    const Eigen::Vector3d rotation = RotationEquation{motion, unweighted}.Error(T.rotation);
    const Eigen::Vector3d translation =
        TranslationEquation{motion, unweighted}.Error(T.rotation, T.translation);
    rotation_norms.push_back(rotation.norm() / motion.sigma_rotation);
    translation_norms.push_back(translation.norm() / motion.sigma_translation);
  }
  Weights out;
  out.rotation_scale = std::max(kSmallestScale, SigmaFromNorms(rotation_norms));
  out.translation_scale = std::max(kSmallestScale, SigmaFromNorms(translation_norms));
  const auto weigh = redescending ? TukeyWeight : AbsoluteWeight;
  double inliers = 0.0, weights = 0.0, square_weights = 0.0;
  for (std::size_t i = 0; i < motions_.size(); ++i) {
    // A motion with a wrong rotation or a wrong translation is wrong as a whole.
    const double weight =
        weigh(rotation_norms[i], out.rotation_scale) * weigh(translation_norms[i], out.translation_scale);
    const double root = std::sqrt(weight / overlap_);
    out.rotation.push_back(root / (motions_[i].sigma_rotation * out.rotation_scale));
    out.translation.push_back(root / (motions_[i].sigma_translation * out.translation_scale));
    inliers += weight > 0.0 ? 1.0 : 0.0;
    weights += weight;
    square_weights += weight * weight;
    out.cost += std::min(rotation_norms[i], 100.0) + std::min(translation_norms[i], 100.0);
  }
  out.information_factor = weights / std::max(square_weights, 1e-300);
  out.inlier_share = inliers / static_cast<double>(motions_.size());
  return out;
}

RigidTransform Fit::Refine(const Eigen::Quaterniond& rotation, int rounds) {
  T_ = {rotation, prior_.T_imu_lidar.translation};
  weights_ = Weigh(T_, false);
  SmallFit fit;
  AddRotations(&fit);
  AddTranslations(&fit);
  AddPrior(&fit);
  fit.SetRotation(&T_.rotation);
  for (int round = 0; round < rounds; ++round) {
    const RigidTransform before = T_;
    const Weights next = Weigh(T_, round >= kConvexRounds);
    // In place: the equations refer to them.
    std::copy(next.rotation.begin(), next.rotation.end(), weights_.rotation.begin());
    std::copy(next.translation.begin(), next.translation.end(), weights_.translation.begin());
    fit.Solve(kStepsInARound);
    const double step =
        AngleBetween(before.rotation, T_.rotation) + (before.translation - T_.translation).norm();
    if (round > kConvexRounds && step < kSettled) break;
  }
  return T_;
}

void Fit::FillResult(const RigidTransform& T, HandEyeResult* result) {
  T_ = T;
  weights_ = Weigh(T, true);
  result->valid = true;
  result->T_imu_lidar = T;
  result->rotation_scale = weights_.rotation_scale;
  result->translation_scale = weights_.translation_scale;
  result->inlier_share = weights_.inlier_share;
  SmallFit rotations, data, prior;
  AddRotations(&rotations);
  AddRotations(&data);
  AddTranslations(&data);
  AddPrior(&prior);
  for (SmallFit* fit : {&rotations, &data, &prior}) fit->SetRotation(&T_.rotation);
  result->information = weights_.information_factor * data.Information({Rotation(), Translation()});
  const Eigen::Matrix3d of_rotations = weights_.information_factor * rotations.Information({Rotation()});
  const SymmetricEigen<3> eigen(of_rotations);
  for (int i = 0; i < 3; ++i) {
    if (eigen.eigenvalues()[i] > 1.0 / (kRotationLimit * kRotationLimit)) ++result->rotation_directions_shown;
  }
  const Matrix6d posterior = result->information + prior.Information({Rotation(), Translation()});
  result->covariance = SolveSymmetric(posterior, Matrix6d::Identity());
}

}  // namespace

HandEyeResult SolveHandEye(const std::vector<RelativeMotion>& motions,
                           const std::optional<ExtrinsicGuess>& guess, double overlap) {
  HandEyeResult result;
  if (motions.size() < 10) {
    result.failure = "fewer than 10 motions that IMU and LiDAR have in common";
    return result;
  }
  const Prior prior(guess);
  const HandEyeRotation start = SolveHandEyeRotation(motions, guess);
  Fit fit(motions, prior, overlap);
  RigidTransform T = fit.Refine(start.R_imu_lidar, kConvexRounds);
  if (start.open) {
    double least = fit.Weigh(T, false).cost;
    constexpr int kStarts = 12;  // from: guard, every 30 deg
    for (int i = 1; i < kStarts; ++i) {
      const Eigen::Vector3d turn = start.open_axis * (2.0 * M_PI * i / kStarts);
      const RigidTransform candidate = fit.Refine(ExpQuaternion(turn) * start.R_imu_lidar, kRoundsOfAStart);
      const double cost = fit.Weigh(candidate, false).cost;
      if (cost >= least) continue;
      least = cost;
      T = candidate;
    }
  }
  fit.FillResult(fit.Refine(T.rotation, kMostRounds), &result);
  return result;
}

}  // namespace mlic
