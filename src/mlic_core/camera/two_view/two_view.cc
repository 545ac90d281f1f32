#include "mlic_core/camera/two_view/two_view.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "mlic_core/camera/two_view/epipolar_refinement.h"
#include "mlic_core/camera/two_view/five_point.h"
#include "mlic_core/common/count_true.h"
#include "mlic_core/common/error.h"
#include "mlic_core/common/order_statistics.h"
#include "mlic_core/common/random.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/geometry/wahba.h"

namespace mlic {
namespace {

// Errors of the angle between R a and b have the noise of two bearings in two directions, those of the
// epipolar error of one bearing in one: the same share of them lies within this many times as much.
constexpr double kRotationErrorFactor = 1.6;  // from: derivation

// Samples drawn even where the first already explain nearly all: theirs may lie badly.
constexpr int kFewestIterations = 50;  // from: guard
constexpr int kMostRefinements = 10;   // from: guard

// Of the matches that a rotation does not explain this share at most meets the epipolar constraint of the
// luckiest translation by chance.
constexpr double kShareByChance = 0.1;
// from: derivation, three angles and two of the direction of translation: a pose meets the matches that it
// was solved from, whatever these are.
constexpr int kMinimalSample = 5;

class Matches {
 public:
  Matches(const std::vector<Eigen::Vector3d>& a, const std::vector<Eigen::Vector3d>& b,
          const TwoViewOptions& options)
      : a_(a), b_(b), options_(options), limit_(options.largest_error * options.largest_error) {}

  int size() const { return static_cast<int>(a_.size()); }

  std::optional<Eigen::Matrix3d> RansacRotation(std::vector<bool>* inlier) const;
  std::optional<RelativePose> RansacPose(std::vector<bool>* inlier) const;

 private:
  double RotationCost(const Eigen::Matrix3d& R, double bound, std::vector<bool>* inlier) const;
  double EssentialCost(const Eigen::Matrix3d& E, double bound, std::vector<bool>* inlier) const;
  Eigen::Matrix3d FitRotation(const std::vector<bool>& inlier) const;
  RelativePose Decompose(const Eigen::Matrix3d& E, const std::vector<bool>& inlier) const;
  RelativePose Polish(RelativePose pose, std::vector<bool>* inlier) const;
  bool InFront(const RelativePose& pose, int i) const;
  int IterationsNeeded(int inliers, int sample) const;

  const std::vector<Eigen::Vector3d>& a_;
  const std::vector<Eigen::Vector3d>& b_;
  const TwoViewOptions& options_;
  const double limit_;
};

Eigen::Matrix3d Essential(const RelativePose& pose) { return Hat(pose.t) * pose.R; }

// Columns: orthonormal, from two directions.
Eigen::Matrix3d Frame(const Eigen::Vector3d& u, const Eigen::Vector3d& v) {
  Eigen::Matrix3d frame;
  frame.col(0) = (u + v).normalized();
  frame.col(1) = u.cross(v).normalized();
  frame.col(2) = frame.col(0).cross(frame.col(1));
  return frame;
}

void DrawDistinct(Random* random, int size, int* indices, int count) {
  for (int k = 0; k < count; ++k) {
    bool again = true;
    while (again) {
      indices[k] = static_cast<int>(random->Next() % static_cast<std::uint64_t>(size));
      again = std::find(indices, indices + k, indices[k]) != indices + k;
    }
  }
}

int Matches::IterationsNeeded(int inliers, int sample) const {
  const double good = std::pow(static_cast<double>(inliers) / size(), sample);
  const int fewest = std::min(kFewestIterations, options_.most_iterations);
  if (good > 0.9999) return fewest;
  if (good < 1e-9) return options_.most_iterations;
  const double needed = std::log(1.0 - options_.confidence) / std::log(1.0 - good);
  return std::max(fewest, static_cast<int>(std::min<double>(options_.most_iterations, needed + 1.0)));
}

// Truncated squared errors in units of the limit; stops where they exceed `bound`.
double Matches::RotationCost(const Eigen::Matrix3d& R, double bound, std::vector<bool>* inlier) const {
  const double limit = limit_ * kRotationErrorFactor * kRotationErrorFactor;
  double cost = 0.0;
  for (int i = 0; i < size() && cost < bound; ++i) {
    const double squared = (R * a_[i] - b_[i]).squaredNorm();
    cost += std::min(1.0, squared / limit);
    if (inlier != nullptr) (*inlier)[i] = squared < limit;
  }
  return cost;
}

double Matches::EssentialCost(const Eigen::Matrix3d& E, double bound, std::vector<bool>* inlier) const {
  double cost = 0.0;
  for (int i = 0; i < size() && cost < bound; ++i) {
    const Eigen::Vector3d Ea = E * a_[i];
    const Eigen::Vector3d Eb = E.transpose() * b_[i];
    const double error = b_[i].dot(Ea);
    const double squared = error * error;
    const double below = limit_ * (Ea.squaredNorm() + Eb.squaredNorm() - 2.0 * squared);
    const bool inside = squared < below;
    cost += inside ? squared / below : 1.0;
    if (inlier != nullptr) (*inlier)[i] = inside;
  }
  return cost;
}

Eigen::Matrix3d Matches::FitRotation(const std::vector<bool>& inlier) const {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (int i = 0; i < size(); ++i) {
    if (inlier[i]) sum += b_[i] * a_[i].transpose();
  }
  return WahbaRotation(sum);
}

std::optional<Eigen::Matrix3d> Matches::RansacRotation(std::vector<bool>* inlier) const {
  Random random(options_.seed);
  std::vector<bool> inside(size());
  Eigen::Matrix3d best;
  double best_cost = size();
  int needed = options_.most_iterations;
  for (int iteration = 0; iteration < needed; ++iteration) {
    int k[2];
    DrawDistinct(&random, size(), k, 2);
    // Two directions that coincide do not make a frame.
    if (a_[k[0]].cross(a_[k[1]]).squaredNorm() < 1e-6 || b_[k[0]].cross(b_[k[1]]).squaredNorm() < 1e-6)
      continue;
    Eigen::Matrix3d R = Frame(b_[k[0]], b_[k[1]]) * Frame(a_[k[0]], a_[k[1]]).transpose();
    double cost = RotationCost(R, best_cost, nullptr);
    for (int refinement = 0; refinement < kMostRefinements && cost < best_cost; ++refinement) {
      best_cost = RotationCost(R, size() + 1.0, &inside);
      best = R;
      *inlier = inside;
      R = FitRotation(inside);
      cost = RotationCost(R, best_cost, nullptr);
      needed = IterationsNeeded(CountTrue(*inlier), 2);
    }
  }
  if (best_cost >= size()) return std::nullopt;
  return best;
}

// Along both bearings the point lies ahead; or so far that its side cannot be told.
bool Matches::InFront(const RelativePose& pose, int i) const {
  const Eigen::Vector3d q = pose.R * a_[i];
  const Eigen::Vector3d& b = b_[i];
  if ((q - b).squaredNorm() < limit_ * kRotationErrorFactor * kRotationErrorFactor) return true;
  // depth_b * b = depth_a * q + t, in least squares; both times the positive determinant.
  const double c = q.dot(b), qt = q.dot(pose.t), bt = b.dot(pose.t);
  return c * bt - qt > 0.0 && bt - c * qt > 0.0;
}

RelativePose Matches::Decompose(const Eigen::Matrix3d& E, const std::vector<bool>& inlier) const {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(E, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d U = svd.matrixU(), V = svd.matrixV();
  if (U.determinant() < 0.0) U.col(2) *= -1.0;
  if (V.determinant() < 0.0) V.col(2) *= -1.0;
  Eigen::Matrix3d W;
  W << 0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0;
  RelativePose best;
  int most = -1;
  for (int candidate = 0; candidate < 4; ++candidate) {
    const Eigen::Matrix3d turn = candidate < 2 ? W : Eigen::Matrix3d(W.transpose());
    const double sign = candidate % 2 == 0 ? 1.0 : -1.0;
    const RelativePose pose{U * turn * V.transpose(), sign * U.col(2)};
    int ahead = 0;
    for (int i = 0; i < size(); ++i) ahead += inlier[i] && InFront(pose, i);
    if (ahead > most) {
      most = ahead;
      best = pose;
    }
  }
  return best;
}

// The limit is wider than the noise may be, and outliers within it would bias the result: the last fit uses
// what lies within three sigmas as measured. `inlier` is by the limit, about the pose returned.
RelativePose Matches::Polish(RelativePose pose, std::vector<bool>* inlier) const {
  const std::vector<bool> candidates = *inlier;
  std::vector<double> errors(size()), of_candidates;
  for (int round = 0; round < 3; ++round) {
    of_candidates.clear();
    for (int i = 0; i < size(); ++i) {
      errors[i] = std::abs(EpipolarError(pose.R, pose.t, a_[i], b_[i]));
      if (candidates[i]) of_candidates.push_back(errors[i]);
    }
    if (of_candidates.size() < 8) break;
    const double largest = std::max(1e-12, 3.0 * 1.4826 * Median(of_candidates));
    std::vector<bool> used(size());
    for (int i = 0; i < size(); ++i) used[i] = candidates[i] && errors[i] < largest;
    pose = RefineRelativePose(pose, a_, b_, used);
  }
  EssentialCost(Essential(pose), size() + 1.0, inlier);
  for (int i = 0; i < size(); ++i) (*inlier)[i] = (*inlier)[i] && InFront(pose, i);
  return pose;
}

std::optional<RelativePose> Matches::RansacPose(std::vector<bool>* inlier) const {
  Random random(options_.seed);
  std::vector<bool> inside(size());
  std::optional<RelativePose> best;
  double best_cost = size();
  int needed = options_.most_iterations;
  for (int iteration = 0; iteration < needed; ++iteration) {
    int k[5];
    DrawDistinct(&random, size(), k, 5);
    const Eigen::Vector3d sample_a[5] = {a_[k[0]], a_[k[1]], a_[k[2]], a_[k[3]], a_[k[4]]};
    const Eigen::Vector3d sample_b[5] = {b_[k[0]], b_[k[1]], b_[k[2]], b_[k[3]], b_[k[4]]};
    Eigen::Matrix3d solutions[kMostEssentialMatrices];
    const int count = SolveFivePoint(sample_a, sample_b, solutions);
    for (int s = 0; s < count; ++s) {
      if (!(EssentialCost(solutions[s], best_cost, nullptr) < best_cost)) continue;
      // Refined at once: a sample's own noise costs inliers, and those cost iterations.
      EssentialCost(solutions[s], size() + 1.0, &inside);
      RelativePose pose = Decompose(solutions[s], inside);
      for (int refinement = 0; refinement < kMostRefinements; ++refinement) {
        const double cost = EssentialCost(Essential(pose), size() + 1.0, &inside);
        if (!(cost < best_cost)) break;
        best_cost = cost;
        best = pose;
        *inlier = inside;
        pose = RefineRelativePose(pose, a_, b_, inside);
      }
      needed = IterationsNeeded(CountTrue(*inlier), 5);
    }
  }
  if (!best) return best;
  // A first hypothesis with few inliers may have grown on the wrong one of the four decompositions.
  best = Decompose(Essential(*best), *inlier);
  for (int i = 0; i < size(); ++i) (*inlier)[i] = (*inlier)[i] && InFront(*best, i);
  return Polish(*best, inlier);
}

}  // namespace

double EpipolarError(const Eigen::Matrix3d& R_b_a, const Eigen::Vector3d& t_b_a,
                     const Eigen::Vector3d& bearing_a, const Eigen::Vector3d& bearing_b) {
  const Eigen::Vector3d q = R_b_a * bearing_a;
  const double e = t_b_a.dot(q.cross(bearing_b));
  const double D = t_b_a.cross(q).squaredNorm() + t_b_a.cross(bearing_b).squaredNorm() - 2.0 * e * e;
  return D > 0.0 ? e / std::sqrt(D) : 0.0;
}

std::optional<TwoViewGeometry> EstimateTwoView(const std::vector<Eigen::Vector3d>& bearings_a,
                                               const std::vector<Eigen::Vector3d>& bearings_b,
                                               const TwoViewOptions& options) {
  Check(bearings_a.size() == bearings_b.size(), "EstimateTwoView: bearings do not come in pairs");
  const Matches matches(bearings_a, bearings_b, options);
  if (matches.size() < std::max(kMinimalSample, options.fewest_inliers)) return std::nullopt;
  TwoViewGeometry by_rotation, by_pose;
  by_rotation.inlier.assign(matches.size(), false);
  by_pose.inlier.assign(matches.size(), false);
  const std::optional<Eigen::Matrix3d> rotation = matches.RansacRotation(&by_rotation.inlier);
  const std::optional<RelativePose> pose = matches.RansacPose(&by_pose.inlier);
  by_rotation.inliers = CountTrue(by_rotation.inlier);
  by_pose.inliers = CountTrue(by_pose.inlier);
  if (rotation) by_rotation.R_b_a = *rotation;
  if (pose) {
    by_pose.R_b_a = pose->R;
    by_pose.t_b_a = pose->t;
    by_pose.has_translation = true;
  }
  const int unexplained = matches.size() - by_rotation.inliers;
  const bool parallax_shown =
      by_pose.inliers - by_rotation.inliers >
      options.least_share_with_parallax * by_pose.inliers + kShareByChance * unexplained + kMinimalSample;
  const TwoViewGeometry& chosen = parallax_shown ? by_pose : by_rotation;
  if (chosen.inliers < options.fewest_inliers) return std::nullopt;
  return chosen;
}

}  // namespace mlic
