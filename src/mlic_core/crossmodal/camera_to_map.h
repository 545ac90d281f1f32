#pragma once

#include <functional>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "mlic_core/crossmodal/cross_modal_matches.h"
#include "mlic_core/crossmodal/nid.h"
#include "mlic_core/crossmodal/pnp.h"
#include "mlic_core/crossmodal/renderer.h"

namespace mlic {

// One photo and where the body (the IMU, or a still LiDAR) was while its rows were exposed.
struct PhotoOnMap {
  cv::Mat gray;  // CV_8UC1
  cv::Mat mask;  // CV_8UC1, 0: ignore; may be empty
  std::function<RigidTransform(double row)> T_map_body;
  bool rolling = false;  // whether the pose hangs on the row
};

struct CameraToMapOptions {
  RenderOptions render;
  CrossModalOptions matching;
  PnpOptions pose;
  NidOptions nid;
  int most_rounds = 4;  // of rendering, matching and solving; from: guard, ends when settled
  // The rounds end when the camera moves by less than this share of its sigma in every direction.
  // from: guard, convergence; most_rounds ends what does not settle.
  double settled = 0.3;
};

struct CameraToMapResult {
  RigidTransform T_body_camera;
  // Of a small rotation (rad, left) and translation (m) of T_camera_body; as PnpResult's.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  std::vector<std::vector<MapMatch>> matches;  // of each photo, inliers of the last round
  double inlier_share = 0.0;
  int rounds = 0;
  bool settled = false;
  double nid_before = 1.0, nid_after = 1.0;  // mean over the photos, at the given and at the found pose
};

// Where a camera sits on a body, from photos of a map, all else held: renders, matches and solves until the
// camera stands still. uncertainty: of the given pose. Nothing when too few matches agree.
std::optional<CameraToMapResult> AlignCameraToMap(const IntensityMap& map, const CameraIntrinsics& intrinsics,
                                                  const std::vector<PhotoOnMap>& photos,
                                                  const RigidTransform& T_body_camera,
                                                  const CameraUncertainty& uncertainty,
                                                  const CameraToMapOptions& options);

}  // namespace mlic
