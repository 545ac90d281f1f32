#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "mlic_core/geometry/rigid_transform.h"
#include "mlic_core/sensors/camera_model.h"

namespace mlic {

// A known point seen by a camera. point: m, in the frame relative to which the camera's pose is wanted
// ("body"). For one image that is the map; for many images of a moving camera it is the IMU's frame when the
// pixel's row was exposed, so that matches of many images, and of rolling shutters, make one problem.
struct PointCorrespondence {
  Eigen::Vector3d point;
  Eigen::Vector2d pixel;
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Identity();  // of the pixel, px^2
};

struct PnpOptions {
  double model_sigma = 0.3;  // px, added to each correspondence's own: what is wrong with the model meanwhile
  // from: derivation, 1 of 450 lies beyond (2 normal coordinates).
  double largest_error = 3.5;  // sigmas, of an inlier
  int fewest_inliers = 15;     // from: guard, callers ask for more
  int most_iterations = 1000;  // from: guard, time and chance of failure
  // from: guard, time and chance of failure.
  double confidence = 0.9999;  // of having drawn one sample without outliers
  std::uint64_t seed = 1;      // from: structural
};

struct PnpResult {
  RigidTransform T_camera_body;
  std::vector<bool> inlier;  // of each correspondence
  int inliers = 0;
  // Of a small rotation (rad, left: Exp(r) * R) and translation (m) of T_camera_body, if correspondences err
  // independently; scaled by chi2 where that exceeds what the covariances allow.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  double chi2 = 0.0;  // mean of the inliers' squared errors by covariance, 1 where covariances are right
};

// The camera's pose from its correspondences, whatever the outliers: RANSAC on three bearings, then
// RefinePose. A guess is one more hypothesis. Nothing when fewer than fewest_inliers agree. Seeded: same
// input, same output. Beside OpenGV's P3P RANSAC with its own refinement (two_view_benchmark, 300 points):
// errors of 0.6 to 0.8 of its, at 70 and 220 deg of view and 0 to 50 percent outliers; 2.1 to 2.9 ms for 1.7
// to 2.7 ms.
std::optional<PnpResult> EstimatePose(const std::vector<PointCorrespondence>& correspondences,
                                      const CameraIntrinsics& intrinsics, const PnpOptions& options,
                                      const RigidTransform* guess = nullptr);

// Least squares of the reprojection errors (Ceres) from a near pose, each by its covariance and with a robust
// loss; inliers are chosen again until they stay the same.
std::optional<PnpResult> RefinePose(const std::vector<PointCorrespondence>& correspondences,
                                    const CameraIntrinsics& intrinsics, const PnpOptions& options,
                                    const RigidTransform& T_camera_body);

}  // namespace mlic
