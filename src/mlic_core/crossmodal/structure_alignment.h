#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "mlic_core/crossmodal/renderer.h"
#include "mlic_core/crossmodal/structure_features.h"

namespace mlic {

// A scan and the photo taken with it, nothing moving.
struct StillPair {
  const IntensityMap* map = nullptr;  // in the body's (the LiDAR's) frame
  cv::Mat gray;                       // CV_8UC1
  cv::Mat mask;                       // CV_8UC1, 0: ignore; may be empty
};

// How well photos show the structure of scans at one image size and one camera pose: normalised correlation
// of the structure features of rendering and photo, all pixels of all pairs in one, -1 to 1. One scan is too
// sparse for templates to find their own places, but all of it together has one clear peak.
class StructureScore {
 public:
  // Renders at T_body_camera; the photos are shrunk by `scale`.
  StructureScore(const std::vector<StillPair>& pairs, const CameraIntrinsics& intrinsics, double scale,
                 const StructureOptions& options, const RigidTransform& T_body_camera);

  // At a pose not far from the one that was rendered. What falls off the photo counts as uncorrelated.
  double At(const RigidTransform& T_camera_body) const;

  const CameraIntrinsics& intrinsics() const { return intrinsics_; }  // at this size
  double weight() const { return weight_; }                           // sum of the pixels'
  double typical_depth() const { return typical_depth_; }             // m, median

 private:
  struct Sample {
    Eigen::Vector3d point;  // body frame
    Eigen::Matrix<float, StructureImage::kChannels, 1> structure;
    float weight;
    std::size_t pair;
  };
  CameraIntrinsics intrinsics_;
  std::vector<StructurePyramid> photos_;
  std::vector<Sample> samples_;
  double weight_ = 0.0, typical_depth_ = 10.0;
};

struct StructureAlignmentOptions {
  std::vector<int> widths{192, 384, 576, 960};  // px, of the shrunk photos, one after the other
  int rounds = 3;                               // of rendering and climbing at each; from: guard, time
  std::size_t candidates = 8;  // peaks of the grid that are climbed at the first; from: guard, time
  std::size_t kept = 3;        // the best of them, climbed at the second; from: guard, time
};

struct StructureAlignment {
  RigidTransform T_body_camera;
  // Of a small rotation (rad, left) and translation (m) of T_camera_body; prior included.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Zero();  // of the data alone
  double score_before = 0.0, score_after = 0.0;                                   // at the last size
  double elsewhere = 0.0;                      // the highest score at poses turned away by degrees
  double first_scale = 1.0, last_scale = 1.0;  // of the photos' sizes
};

// The pose that maximises StructureScore, coarse to fine, with a Gaussian prior about the start: first the
// peaks of a grid of rotations within 2.5 sigmas, then Newton steps. prior: covariance as CameraUncertainty's
// pose. Does not depend on the number of threads.
StructureAlignment AlignByStructure(const std::vector<StillPair>& pairs, const CameraIntrinsics& intrinsics,
                                    const RigidTransform& T_body_camera,
                                    const Eigen::Matrix<double, 6, 6>& prior,
                                    const StructureAlignmentOptions& options);

}  // namespace mlic
