#pragma once

#include <Eigen/Core>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "mlic_core/camera/features/features.h"

namespace mlic {

// Feature a of the first set and feature b of the second may be the same point. score: more is better.
struct FeatureMatch {
  int a = 0;
  int b = 0;
  float score = 0.0f;
};

// What is known of two views before they are matched. Bearings: one for each feature, unit vectors in the
// frames of the two views; a zero vector where the model has none. Only matches whose epipolar error is below
// largest_error (rad) are looked for. t_b_a: unit; zero where the views have no known distance: then R_b_a *
// bearing_a and bearing_b are within largest_error.
struct MatchGuide {
  Eigen::Matrix3d R_b_a = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t_b_a = Eigen::Vector3d::Zero();
  double largest_error = 0.05;
  const std::vector<Eigen::Vector3d>* bearings_a = nullptr;
  const std::vector<Eigen::Vector3d>* bearings_b = nullptr;
};

// Finds features in images and the same ones in two images. All functions may be called by several threads at
// once.
class FeatureMatcher {
 public:
  virtual ~FeatureMatcher() = default;
  // Tells feature sets of different backends or options apart (for stored ones).
  virtual std::string Name() const = 0;
  // gray: CV_8UC1; mask: CV_8UC1 of the same size, 0 is left out; may be empty.
  virtual FeatureSet Detect(const cv::Mat& gray, const cv::Mat& mask) const = 0;
  // Each feature at most once, ordered by a. width and height of both images are needed by learned matchers
  // only. guide: null where nothing is known.
  virtual std::vector<FeatureMatch> Match(const FeatureSet& a, const FeatureSet& b,
                                          const MatchGuide* guide) const = 0;
};

struct ClassicalMatcherOptions {
  FeatureOptions features;
  // Largest ratio of the distances to the nearest and the second nearest descriptor. Guided, there are few
  // candidates and so fewer false ones: a larger ratio is as safe.
  double largest_ratio = 0.85;
  double largest_guided_ratio = 0.9;
  double largest_distance = 0.75;  // of descriptors normalised to unit length (RootSIFT)
};

// SIFT, mutual nearest neighbours and the ratio of the two nearest.
std::unique_ptr<FeatureMatcher> MakeClassicalMatcher(const ClassicalMatcherOptions& options = {});

}  // namespace mlic
