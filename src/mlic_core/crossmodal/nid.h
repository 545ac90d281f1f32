#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "mlic_core/geometry/rigid_transform.h"
#include "mlic_core/sensors/camera_model.h"

namespace mlic {

// Normalised information distance: how little a photo tells about a rendering and the other way round, 0
// (everything) to 1 (nothing), whatever the relation between their brightnesses. A metric, from entropies of
// the joint histogram: 2 - (H(A) + H(B)) / H(A, B) (Stewart and Newman, "LAPS", ICRA 2012). An independent
// check of a calibration: lower is better. Values are ranked first (histogram equalisation) and counted with
// cubic B-spline weights, so that NID changes smoothly with pose.
struct NidOptions {
  int bins = 16;             // from: paper, Koide et al. 2023 (ICRA)
  int fewest_samples = 500;  // from: guard, views have some 1e5
};

// NID of pairs of values, in any units; 1 with fewer than fewest_samples pairs.
double NormalizedInformationDistance(const std::vector<float>& a, const std::vector<float>& b,
                                     const NidOptions& options);

// Of a rendering and a photo of one size. intensity: CV_32FC1, NaN where nothing is seen; gray: CV_8UC1;
// mask: CV_8UC1, 0: ignore; may be empty.
double ViewNid(const cv::Mat& intensity, const cv::Mat& gray, const cv::Mat& mask, const NidOptions& options);

// A visible map point of known intensity. point: m, body frame (as PointCorrespondence's).
struct IntensitySample {
  Eigen::Vector3d point;
  float intensity = 0.0f;
};

// Of map points projected into a photo at a pose: the same without rendering anew, for small changes of pose.
// Points outside the image or the mask do not count.
double ProjectedNid(const std::vector<IntensitySample>& samples, const cv::Mat& gray, const cv::Mat& mask,
                    const CameraIntrinsics& intrinsics, const RigidTransform& T_camera_body,
                    const NidOptions& options);

}  // namespace mlic
