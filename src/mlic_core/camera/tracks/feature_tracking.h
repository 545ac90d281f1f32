#pragma once

#include <vector>

#include "mlic_core/camera/features/features.h"
#include "mlic_core/camera/tracks/tracks.h"
#include "mlic_core/common/progress.h"
#include "mlic_core/sensors/images.h"

namespace mlic {

// Descriptors are compared between keyframes, which lie far apart in a turn. Between consecutive images
// little changes, so features are also followed through all images from one keyframe to the next (Lucas and
// Kanade, pyramidal).
struct FollowOptions {
  bool enabled = true;
  int most_features = 500;  // followed at a time; from: guard, time
  int window = 15;          // px
  // from: guard, 15 px at the coarsest are 240 px of the image.
  int levels = 4;                    // of the pyramid above the image
  double largest_difference = 14.0;  // mean of the absolute differences of gray values from image to image
  // from: guard, both err by tenths of a pixel, features are some 10 px apart.
  double snap = 1.0;              // px: a feature that is so near to the place found is the same
  double largest_interval = 3.0;  // s between keyframes
};

// Indices first .. last - 1.
struct KeyframeRange {
  std::size_t first = 0, last = 0;
};

// Follows features of one camera's keyframes (`range` of `keyframes`, all of one camera).
// Where no feature of the next keyframe is at the place found, one without descriptor is added to it
// (features[k] grows at its end). mask: as FindStaticPixels makes it. Returns the matches of consecutive
// keyframes, not verified.
std::vector<PairMatches> FollowFeatures(const ImageSource& images, const cv::Mat& mask,
                                        const std::vector<Keyframe>& keyframes, const KeyframeRange& range,
                                        const FollowOptions& options, std::vector<FeatureSet>* features,
                                        const CancellationToken* cancellation = nullptr);

}  // namespace mlic
