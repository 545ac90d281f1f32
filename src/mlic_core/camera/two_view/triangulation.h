#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace mlic {

// One observation of a point: from `centre` along the unit vector `direction`, both in the map frame.
struct BearingObservation {
  Eigen::Vector3d centre;
  Eigen::Vector3d direction;
  double sigma = 1e-3;  // rad, of each of the two angles of `direction`
};

struct TriangulationOptions {
  // from: derivation, 1 of 3000 lies beyond (2 normal coordinates).
  double largest_error = 4.0;       // of an observation that agrees, in its sigmas
  double least_parallax_deg = 0.5;  // of the largest angle between two rays at the point
  double least_inlier_share = 0.5;  // from: definition, a point is what most of its observations show
  double farthest = 1e4;            // m, from any centre; from: guard, as good as at infinity
};

struct TriangulatedPoint {
  Eigen::Vector3d position;    // map frame
  Eigen::Matrix3d covariance;  // m^2, from the sigmas of the observations as given
  double parallax = 0.0;       // rad
  double rms = 0.0;            // of the whitened angular errors of the inliers; 1 where the sigmas are right
  std::vector<bool> inlier;
  int inliers = 0;
};

// The point that agrees best with at least two observations: least squares of the whitened angular errors
// over those observations that agree with the most others. Nothing where too few agree, after dropping any
// fewer than three, where the parallax is too small, or where the point is behind a camera. Own Gauss-Newton
// and not Ceres: 4 us for all of it with 12 observations, where Ceres' refinement alone takes 16 us
// (small_fit_benchmark), and every round of landmarks asks for every track.
std::optional<TriangulatedPoint> TriangulatePoint(const std::vector<BearingObservation>& observations,
                                                  const TriangulationOptions& options = {});

}  // namespace mlic
