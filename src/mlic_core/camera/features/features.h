#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace mlic {

// The features of one image: plain vectors of one entry for each feature, so that they can be stored.
struct FeatureSet {
  std::vector<Eigen::Vector2f> pixels;  // a pixel's centre is at integer coordinates
  std::vector<float> scales;            // px, the sigma of the blob
  std::vector<float> angles;            // rad, of the patch in the image
  std::vector<float> scores;            // more is better
  int descriptor_size = 0;
  std::vector<std::uint8_t> descriptors;  // classical: descriptor_size bytes for each feature
  std::vector<float> float_descriptors;   // learned: descriptor_size numbers for each feature
  int width = 0, height = 0;              // learned: px, of the image

  std::size_t Count() const { return pixels.size(); }
};

struct FeatureOptions {
  int most_features = 1500;  // of one image; from: guard, time
  // from: structural, parts of the image.
  int grid = 12;                     // cells along the longer side: each gets its share of the features
  double contrast_threshold = 0.02;  // of SIFT, on gray values of 0 to 1, over three layers
  // from: guard, a patch of 9 px either way (TrackRefinementOptions) has to fit in any case.
  int border = 8;  // px kept clear at the image's edge and around masked pixels
};

// SIFT (Lowe, 2004) of a gray image (CV_8UC1), spread over the image by a grid. mask: CV_8UC1, 0 is left out;
// may be empty. Deterministic.
FeatureSet DetectSift(const cv::Mat& gray, const cv::Mat& mask, const FeatureOptions& options);

// The pixels of an image (255, others 0) that are `border` px away from its edge and from masked pixels.
cv::Mat AllowedPixels(const cv::Mat& mask, const cv::Size& size, int border);

// Indices of at most `most` of the points, the best of each cell of a grid first: every cell gives its best
// one, then every cell its second, and so on. In order of index.
std::vector<int> SpreadOverImage(const std::vector<Eigen::Vector2f>& pixels, const std::vector<float>& scores,
                                 int width, int height, int grid, int most);

}  // namespace mlic
