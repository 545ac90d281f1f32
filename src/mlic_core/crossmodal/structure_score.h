#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "mlic_core/crossmodal/intensity_map.h"
#include "mlic_core/crossmodal/structure_features.h"
#include "mlic_core/geometry/rigid_transform.h"
#include "mlic_core/sensors/camera_model.h"

namespace mlic {

// A scan and the photo taken with it, nothing moving.
struct StillPair {
  const IntensityMap* map = nullptr;  // in the body's (the LiDAR's) frame
  cv::Mat gray;                       // CV_8UC1
  cv::Mat mask;                       // CV_8UC1, 0: ignore; may be empty
};

// The structure of the photos at one image size.
struct ShrunkPhotos {
  CameraIntrinsics intrinsics;  // at this size
  std::vector<StructurePyramid> structure;
};

ShrunkPhotos ShrinkPhotos(const std::vector<StillPair>& pairs, const CameraIntrinsics& intrinsics,
                          double scale, const StructureOptions& options);

// How well photos show the structure of scans at one image size and one camera pose. One scan is too sparse
// for templates to find their own places, but all of it together has one clear peak.
class StructureScore {
 public:
  struct Value {
    double correlation = 0.0;  // normalised, of all pixels of all pairs in one, -1 to 1
    double weight = 0.0;       // of the rendering, in pixels of the photo that it takes at the pose
  };

  // Renders the pairs' scans at T_body_camera. photos: of the same pairs; must outlive it.
  StructureScore(const std::vector<StillPair>& pairs, const ShrunkPhotos& photos,
                 const StructureOptions& options, const RigidTransform& T_body_camera);

  // At a pose not far from the one that was rendered. Surfaces count for as many pixels as they take there,
  // or the score would rise where what does not fit is seen at a flatter angle. What falls off the photo
  // counts as uncorrelated.
  Value At(const RigidTransform& T_camera_body) const;

  const CameraIntrinsics& intrinsics() const { return photos_->intrinsics; }
  double typical_depth() const { return typical_depth_; }  // m, median

 private:
  struct Sample {
    Eigen::Vector3d point;   // body frame
    Eigen::Vector3d normal;  // unit, towards the camera; zero where there is no plane
    double area;             // of the surface as if it faced the camera from a metre: what its pixels show
    Eigen::Matrix<float, StructureImage::kChannels, 1> structure;
    float weight;
    std::size_t pair;
  };
  const ShrunkPhotos* photos_;
  std::vector<Sample> samples_;
  double typical_depth_ = 10.0;
};

}  // namespace mlic
