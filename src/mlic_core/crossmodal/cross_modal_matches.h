#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "mlic_core/crossmodal/renderer.h"
#include "mlic_core/crossmodal/structure_features.h"
#include "mlic_core/crossmodal/structure_matcher.h"

namespace mlic {

// How wrong the camera may be whose view was rendered: what sizes the search windows.
struct CameraUncertainty {
  // Of a small rotation (rad, left) and translation (m) of T_camera_body, camera frame; as PnpResult's.
  Eigen::Matrix<double, 6, 6> pose = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::MatrixXd intrinsics;  // of CameraIntrinsics::parameters; may be empty
  double displacement = 0.5;   // px, of all the rest
};

// Independent errors of these sizes in each direction.
CameraUncertainty UncertaintyOf(double sigma_rotation, double sigma_translation);

// Covariance (px^2) of where a camera sees a point that it is thought to see at `point` (m, camera frame).
Eigen::Matrix2d DisplacementCovariance(const CameraIntrinsics& intrinsics, const Eigen::Vector3d& point,
                                       const CameraUncertainty& uncertainty);

// A place of the map found in a photo.
struct MapMatch {
  Eigen::Vector3d point;        // on the map's surface, m, map frame
  std::int32_t map_point = -1;  // index of the nearest of IntensityMap::points: its LiDAR and time
  Eigen::Vector2d pixel;        // in the photo
  Eigen::Matrix2d covariance;   // of the pixel, px^2
  Eigen::Vector2d rendered;     // where the rendering's calibration has it, px
  double score = 0.0;           // normalised correlation
  double peak_ratio = 0.0;      // second peak by best
};

struct CrossModalOptions {
  StructureOptions structure;
  StructureMatchOptions match;
};

// The rendered view as features need it.
RenderedStructure StructureOf(const RenderedView& view, const CameraIntrinsics& intrinsics,
                              const ViewPose& pose);

// Matches a rendered view with the photo taken from about there. view: rendered with `intrinsics` from
// `pose`; gray: CV_8UC1 of the same size; mask: CV_8UC1, 0: ignore; may be empty. In order of image cells;
// the same for any number of threads.
std::vector<MapMatch> MatchView(const RenderedView& view, const CameraIntrinsics& intrinsics,
                                const ViewPose& pose, const cv::Mat& gray, const cv::Mat& mask,
                                const CameraUncertainty& uncertainty, const CrossModalOptions& options);

// The same with the photo's structure made before (PhotoStructure with options.structure): a photo's does not
// change while its camera is found.
std::vector<MapMatch> MatchView(const RenderedView& view, const CameraIntrinsics& intrinsics,
                                const ViewPose& pose, const StructurePyramid& photo,
                                const CameraUncertainty& uncertainty, const CrossModalOptions& options);

}  // namespace mlic
