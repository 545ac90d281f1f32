#pragma once

#include <opencv2/core/mat.hpp>

#include "mlic_core/camera/features/features.h"
#include "mlic_core/camera/learned/learned_network.h"

namespace mlic {

// SuperPoint (DeTone, Malisiewicz and Rabinovich, CVPR-W 2018), with the selection of keypoints in the
// network: image [1, 1, H, W], gray values of 0 to 1, H and W multiples of 8; returns keypoints [1, N, 2] (x,
// y; a pixel's centre is at integers), scores [1, N], descriptors [1, N, 256]. The leading 1 may be missing
// in what it returns.
NetworkSignature DetectorSignature();

struct LearnedDetectionOptions {
  // from: guard, time and memory.
  int longest_side = 1024;  // px: larger images are made smaller, by means over areas; others stay
  // Of the network's features, spread over the image. Fewer than classical ones: a matcher takes a second and
  // more for each pair. from: guard, time.
  int most_features = 1000;
  int grid = 12;   // as in FeatureOptions; from: structural
  int border = 8;  // likewise; from: guard, as there
};

// Features of a gray image (CV_8UC1), in its own pixels. mask: as in DetectSift. Scale and angle are the same
// for all, as SuperPoint knows none. Throws InputError where the network returns something else than
// announced; `file` is for the message.
FeatureSet DetectLearned(const Network& detector, const std::string& file, const cv::Mat& gray,
                         const cv::Mat& mask, const LearnedDetectionOptions& options);

}  // namespace mlic
