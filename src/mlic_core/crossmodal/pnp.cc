#include "mlic_core/crossmodal/pnp.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "mlic_core/common/count_true.h"
#include "mlic_core/common/random.h"
#include "mlic_core/crossmodal/three_point.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/solver/small_fit.h"

namespace mlic {
namespace {

constexpr int kFewestIterations = 30;  // from: guard
constexpr int kMostRounds = 10;        // of choosing inliers; from: guard
constexpr int kMostSteps = 20;         // of one round; from: guard, ends by convergence
// from: derivation, Huber's loss keeps 96 % of efficiency.
constexpr double kRobustLimit = 1.5;  // sigmas: errors beyond count less (Huber)
// from: guard.
constexpr double kLeastSampleArea = 0.05;  // of three bearings' triangle, rad^2: smaller ones fix no pose

class Correspondences {
 public:
  Correspondences(const std::vector<PointCorrespondence>& correspondences, const CameraIntrinsics& intrinsics,
                  const PnpOptions& options)
      : correspondences_(correspondences), intrinsics_(intrinsics), options_(options) {
    const Eigen::Matrix2d slack = options.model_sigma * options.model_sigma * Eigen::Matrix2d::Identity();
    for (const PointCorrespondence& correspondence : correspondences) {
      const Eigen::LLT<Eigen::Matrix2d> cholesky(correspondence.covariance + slack);
      whitening_.push_back(cholesky.matrixL().solve(Eigen::Matrix2d::Identity()));
    }
  }

  std::size_t size() const { return correspondences_.size(); }

  const Eigen::Vector3d& Point(std::size_t i) const { return correspondences_[i].point; }

  // Whitened error, and its derivative to the point in the camera's frame; false where the camera cannot see
  // the point.
  bool Error(const RigidTransform& pose, std::size_t i, Eigen::Vector2d* error,
             CameraPointJacobian* J = nullptr) const {
    Eigen::Vector2d pixel;
    if (!Project(intrinsics_, pose * correspondences_[i].point, &pixel, J)) return false;
    *error = whitening_[i] * (pixel - correspondences_[i].pixel);
    if (J != nullptr) *J = (whitening_[i] * *J).eval();
    return true;
  }

  // Truncated squared errors in units of the limit; stops where they exceed `bound`.
  double Cost(const RigidTransform& pose, double bound) const {
    const double limit = options_.largest_error * options_.largest_error;
    double cost = 0.0;
    Eigen::Vector2d error;
    for (std::size_t i = 0; i < size() && cost < bound; ++i) {
      cost += Error(pose, i, &error) ? std::min(1.0, error.squaredNorm() / limit) : 1.0;
    }
    return cost;
  }

  std::vector<bool> Inliers(const RigidTransform& pose) const {
    std::vector<bool> inlier(size());
    Eigen::Vector2d error;
    for (std::size_t i = 0; i < size(); ++i) {
      inlier[i] = Error(pose, i, &error) && error.norm() < options_.largest_error;
    }
    return inlier;
  }

 private:
  const std::vector<PointCorrespondence>& correspondences_;
  const CameraIntrinsics& intrinsics_;
  const PnpOptions& options_;
  std::vector<Eigen::Matrix2d> whitening_;
};

// Moves the pose to the inliers' optimum. False where there is none. information: of a small left rotation
// and a translation.
bool Optimize(const Correspondences& correspondences, const std::vector<bool>& inlier, RigidTransform* pose,
              Eigen::MatrixXd* information) {
  const std::vector<double*> blocks = {pose->rotation.coeffs().data(), pose->translation.data()};
  SmallFit fit;
  for (std::size_t i = 0; i < correspondences.size(); ++i) {
    if (!inlier[i]) continue;
    const auto residual = [&correspondences, i](double const* const* at, double* r, double** jacobians) {
      const RigidTransform T{Eigen::Quaterniond(at[0]), Eigen::Vector3d(at[1])};
      Eigen::Vector2d error;
      CameraPointJacobian J;
      if (!correspondences.Error(T, i, &error, jacobians != nullptr ? &J : nullptr)) return false;
      Eigen::Map<Eigen::Vector2d>(r, 2) = error;
      if (jacobians == nullptr) return true;
      const Eigen::Matrix3d turning = -Hat(T.rotation * correspondences.Point(i));
      StoreJacobian(J * turning * LeftPerturbationJacobian(T.rotation), 0, jacobians);
      StoreJacobian(J, 1, jacobians);
      return true;
    };
    fit.Add(2, residual, {{blocks[0], 4}, {blocks[1], 3}}, kRobustLimit);
  }
  fit.SetRotation(&pose->rotation);
  if (!fit.Solve(kMostSteps).usable) return false;
  *information = fit.Information(blocks);
  return Eigen::LLT<Eigen::MatrixXd>(*information).info() == Eigen::Success;
}

int IterationsNeeded(double inlier_share, const PnpOptions& options) {
  const double good = inlier_share * inlier_share * inlier_share;
  const int fewest = std::min(kFewestIterations, options.most_iterations);
  if (good > 0.9999) return fewest;
  if (good < 1e-9) return options.most_iterations;
  const double needed = std::log(1.0 - options.confidence) / std::log(1.0 - good);
  return std::max(fewest, static_cast<int>(std::min<double>(options.most_iterations, needed + 1.0)));
}

}  // namespace

std::optional<PnpResult> RefinePose(const std::vector<PointCorrespondence>& correspondences,
                                    const CameraIntrinsics& intrinsics, const PnpOptions& options,
                                    const RigidTransform& T_camera_body) {
  const Correspondences all(correspondences, intrinsics, options);
  PnpResult result;
  result.T_camera_body = T_camera_body;
  Eigen::MatrixXd information;
  for (int round = 0; round < kMostRounds; ++round) {
    std::vector<bool> inlier = all.Inliers(result.T_camera_body);
    if (inlier == result.inlier) break;
    result.inlier = std::move(inlier);
    result.inliers = CountTrue(result.inlier);
    if (result.inliers < std::max(3, options.fewest_inliers)) return std::nullopt;
    if (!Optimize(all, result.inlier, &result.T_camera_body, &information)) return std::nullopt;
  }
  double squares = 0.0;
  int count = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    Eigen::Vector2d error;
    if (!result.inlier[i] || !all.Error(result.T_camera_body, i, &error)) continue;
    squares += error.squaredNorm();
    ++count;
  }
  result.chi2 = squares / std::max(1, 2 * count - 6);
  result.covariance = std::max(1.0, result.chi2) * information.inverse();
  return result;
}

std::optional<PnpResult> EstimatePose(const std::vector<PointCorrespondence>& correspondences,
                                      const CameraIntrinsics& intrinsics, const PnpOptions& options,
                                      const RigidTransform* guess) {
  const Correspondences all(correspondences, intrinsics, options);
  std::vector<Eigen::Vector3d> bearings;
  std::vector<std::size_t> usable;
  for (std::size_t i = 0; i < correspondences.size(); ++i) {
    Eigen::Vector3d bearing = Eigen::Vector3d::Zero();
    if (Unproject(intrinsics, correspondences[i].pixel, &bearing)) usable.push_back(i);
    bearings.push_back(bearing);
  }
  if (static_cast<int>(usable.size()) < std::max(3, options.fewest_inliers)) return std::nullopt;
  RigidTransform best;
  double least = static_cast<double>(correspondences.size());
  const auto consider = [&](const RigidTransform& pose) {
    const double cost = all.Cost(pose, least);
    if (cost >= least) return false;
    best = pose, least = cost;
    return true;
  };
  if (guess != nullptr) consider(*guess);
  Random random(options.seed);
  int needed = options.most_iterations;
  for (int i = 0; i < needed; ++i) {
    std::size_t s[3];
    for (std::size_t& k : s) k = usable[random.Next() % usable.size()];
    const Eigen::Vector3d b[3] = {bearings[s[0]], bearings[s[1]], bearings[s[2]]};
    if ((b[1] - b[0]).cross(b[2] - b[0]).norm() < kLeastSampleArea) continue;
    const Eigen::Vector3d p[3] = {correspondences[s[0]].point, correspondences[s[1]].point,
                                  correspondences[s[2]].point};
    RigidTransform poses[kMostThreePointPoses];
    const int count = SolveThreePoint(b, p, poses);
    bool better = false;
    for (int k = 0; k < count; ++k) better |= consider(poses[k]);
    if (better) {
      const double share = CountTrue(all.Inliers(best)) / static_cast<double>(correspondences.size());
      needed = std::min(options.most_iterations, std::max(i + 1, IterationsNeeded(share, options)));
    }
  }
  return RefinePose(correspondences, intrinsics, options, best);
}

}  // namespace mlic
