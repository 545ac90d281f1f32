#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

namespace mlic {

// The relative pose of two views from matches of bearing vectors. Works on the sphere, so at any angle from
// the optical axis: nothing is divided by z.
struct TwoViewOptions {
  // Largest angular error of a match, rad: how far its two bearings must turn to meet the epipolar constraint
  // (about three sigmas of one bearing). 2 px at a focal length of 400 px is 0.005. from: structural, every
  // caller sets its own.
  double largest_error = 0.004;
  int fewest_inliers = 15;
  // Translation counts as shown when it explains, beyond what a rotation alone and chance do, at least this
  // share of the inliers.
  double least_share_with_parallax = 0.02;
  int most_iterations = 1000;  // from: guard, time and chance of failure
  // from: guard, time and chance of failure.
  double confidence = 0.9999;  // of having drawn one sample without outliers
  std::uint64_t seed = 1;      // from: structural
};

struct TwoViewGeometry {
  Eigen::Matrix3d R_b_a = Eigen::Matrix3d::Identity();  // p_b = R_b_a * p_a + t_b_a
  Eigen::Vector3d t_b_a = Eigen::Vector3d::Zero();      // unit, or zero where not shown
  bool has_translation = false;
  std::vector<bool> inlier;  // of each match
  int inliers = 0;
};

// bearings_a[i] and bearings_b[i]: unit vectors to one point, in the frames of views a and b. RANSAC on the
// essential matrix and on a rotation alone, then least squares of the epipolar error over rotation and
// direction of translation. Nothing when fewer than fewest_inliers agree. Points on
// one plane alone are explained by two poses, of which either may come back; their inliers are the same.
// Seeded: same input, same output. Beside OpenGV's five-point RANSAC (two_view_benchmark, 300 matches): 1.9
// ms and 0.017 deg for 5.0 ms and 0.023 deg without outliers, 6.5 ms and 0.026 deg for 47 ms and 0.036 deg
// with 50 percent; as good at 220 deg of view.
std::optional<TwoViewGeometry> EstimateTwoView(const std::vector<Eigen::Vector3d>& bearings_a,
                                               const std::vector<Eigen::Vector3d>& bearings_b,
                                               const TwoViewOptions& options);

// The angular epipolar error (rad) of one match: first-order distance of the two bearings to the nearest pair
// that fulfils b . (t x R a) = 0 (Sampson's distance on the sphere). t: unit.
double EpipolarError(const Eigen::Matrix3d& R_b_a, const Eigen::Vector3d& t_b_a,
                     const Eigen::Vector3d& bearing_a, const Eigen::Vector3d& bearing_b);

}  // namespace mlic
