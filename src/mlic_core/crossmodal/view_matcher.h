#pragma once

#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "mlic_core/camera/features/feature_matcher.h"
#include "mlic_core/crossmodal/cross_modal_matches.h"

namespace mlic {

// A photo and the map drawn as its camera would see it, of one size.
struct ViewPair {
  const RenderedView& view;  // drawn with `intrinsics` from `pose`
  const CameraIntrinsics& intrinsics;
  const ViewPose& pose;
  const cv::Mat& gray;  // CV_8UC1
  const cv::Mat& mask;  // CV_8UC1, 0: ignore; may be empty
};

// Finds places of a rendering in the photo. May be called by several threads at once.
class ViewMatcher {
 public:
  virtual ~ViewMatcher() = default;
  // level: each one halves both images; 0 is full resolution. Nothing is looked for beyond what the
  // uncertainty of the camera allows.
  virtual std::vector<MapMatch> Match(const ViewPair& pair, const CameraUncertainty& uncertainty,
                                      int level) const = 0;
};

// By structure: templates of edges and their orientations, found to a fraction of a pixel (MatchView). What
// the calibration uses unless learned networks are given.
std::unique_ptr<ViewMatcher> MakeStructureViewMatcher();

// By features of both images, such as learned ones, which must outlive it. Places are as good as those of the
// features: some tenths of a pixel at best.
std::unique_ptr<ViewMatcher> MakeFeatureViewMatcher(const FeatureMatcher& features);

}  // namespace mlic
