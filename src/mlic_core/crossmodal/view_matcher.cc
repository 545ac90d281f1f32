#include "mlic_core/crossmodal/view_matcher.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace mlic {
namespace {

// px of the level matched at, of a displacement along one axis. Scatter beyond it enlarges the sigmas of a
// camera's matches, less does not lower them (association/map_matches.cc). from: paper, SuperPoint (DeTone et
// al., 2018): two views' places of a feature on HPatches are 1.16 px apart in the mean, of Rayleigh's
// distribution.
constexpr double kPlaceSigma = 0.92;
// from: derivation, 1 % of normal errors lie beyond; as StructureMatchOptions'.
constexpr double kSearchSigmas = 3.0;
constexpr double kLargestSearch = 80.0;  // px, as StructureMatchOptions'; from: guard

// How photos are matched at a level of the pyramids. At full resolution edges of depth hardly count, as beams
// displace them by a third of a pixel. At coarser ones that is within the error of a match, and they are most
// of what a sparse LiDAR shows.
CrossModalOptions MatchingAt(int level) {
  CrossModalOptions options;
  options.structure.finest_level = level;
  if (level == 0) return options;
  options.structure.depth_trust = options.structure.depth_weight = 1.0;
  options.match.least_trusted = 0.0;
  return options;
}

class StructureViewMatcher : public ViewMatcher {
 public:
  std::vector<MapMatch> Match(const ViewPair& pair, const CameraUncertainty& uncertainty,
                              int level) const override {
    return MatchView(pair.view, pair.intrinsics, pair.pose, pair.gray, pair.mask, uncertainty,
                     MatchingAt(level));
  }
};

cv::Mat Halved(const cv::Mat& image, int level) {
  cv::Mat halved = image;
  for (int l = 0; l < level && !halved.empty(); ++l) {
    cv::Mat smaller;
    cv::resize(halved, smaller, cv::Size(halved.cols / 2, halved.rows / 2), 0.0, 0.0, cv::INTER_AREA);
    halved = smaller;
  }
  return halved;
}

// The features of an image made smaller, at their pixels of the whole one.
struct PlacedFeatures {
  FeatureSet features;
  std::vector<Eigen::Vector2d> pixels;
  std::vector<Eigen::Vector3d> bearings;
};

PlacedFeatures Place(FeatureSet features, const CameraIntrinsics& intrinsics, int level) {
  PlacedFeatures placed;
  for (const Eigen::Vector2f& pixel : features.pixels) {
    const Eigen::Vector2d whole(FromLevel(pixel.x(), level), FromLevel(pixel.y(), level));
    Eigen::Vector3d bearing;
    placed.pixels.push_back(whole);
    placed.bearings.push_back(Unproject(intrinsics, whole, &bearing) ? bearing.normalized().eval()
                                                                     : Eigen::Vector3d::Zero().eval());
  }
  placed.features = std::move(features);
  return placed;
}

// The rendering as a photo: what is not seen gets the mean, so that its border is no edge, and is masked.
cv::Mat AsPhoto(const cv::Mat& intensity, cv::Mat* mask) {
  *mask = cv::Mat(intensity == intensity);  // no number is unequal to itself
  cv::Mat gray(intensity.size(), CV_8UC1, cv::Scalar(255.0 * cv::mean(intensity, *mask)[0]));
  cv::Mat whole;
  intensity.convertTo(whole, CV_8UC1, 255.0);
  whole.copyTo(gray, *mask);
  return gray;
}

bool IsIn(const cv::Mat& image, const Eigen::Vector2d& pixel) {
  return pixel.x() >= 0.0 && pixel.y() >= 0.0 && pixel.x() < image.cols && pixel.y() < image.rows;
}

class FeatureViewMatcher : public ViewMatcher {
 public:
  explicit FeatureViewMatcher(const FeatureMatcher& features) : features_(features) {}

  std::vector<MapMatch> Match(const ViewPair& pair, const CameraUncertainty& uncertainty,
                              int level) const override {
    cv::Mat seen;
    const cv::Mat drawn = AsPhoto(pair.view.intensity, &seen);
    const PlacedFeatures a = Find(drawn, seen, pair.intrinsics, level);
    const PlacedFeatures b = Find(pair.gray, pair.mask, pair.intrinsics, level);
    const Eigen::Matrix2d own = std::pow(kPlaceSigma * (1 << level), 2) * Eigen::Matrix2d::Identity();
    std::vector<Eigen::Matrix2d> predicted;
    double largest = 0.0;  // px^2
    for (std::size_t i = 0; i < a.pixels.size(); ++i) {
      predicted.push_back(own + Predicted(pair, a.pixels[i], a.bearings[i], uncertainty));
      largest = std::max(largest, predicted.back().trace());
    }
    MatchGuide guide;
    guide.largest_error =
        std::min(kLargestSearch, kSearchSigmas * std::sqrt(largest)) / pair.intrinsics.parameters[0];
    guide.bearings_a = &a.bearings;
    guide.bearings_b = &b.bearings;
    std::vector<MapMatch> matches;
    for (const FeatureMatch& found : features_.Match(a.features, b.features, &guide)) {
      const auto ia = static_cast<std::size_t>(found.a);
      const Eigen::Vector2d displacement = b.pixels[static_cast<std::size_t>(found.b)] - a.pixels[ia];
      const double distance = displacement.dot(predicted[ia].inverse() * displacement);
      if (displacement.norm() > kLargestSearch || distance > kSearchSigmas * kSearchSigmas) continue;
      MapMatch match;
      match.rendered = a.pixels[ia];
      if (!IsIn(pair.view.point, match.rendered) ||
          !SurfaceAt(pair.view, pair.intrinsics, pair.pose, match.rendered, &match.point)) {
        continue;
      }
      match.map_point = pair.view.point.at<std::int32_t>(static_cast<int>(match.rendered.y()),
                                                         static_cast<int>(match.rendered.x()));
      match.pixel = match.rendered + displacement;
      match.covariance = own;
      match.score = found.score;
      if (match.map_point >= 0) matches.push_back(match);
    }
    return matches;
  }

 private:
  PlacedFeatures Find(const cv::Mat& gray, const cv::Mat& mask, const CameraIntrinsics& intrinsics,
                      int level) const {
    cv::Mat allowed = Halved(mask, level);
    if (!allowed.empty()) allowed = allowed == 255;  // of wholly known pixels only
    return Place(features_.Detect(Halved(gray, level), allowed), intrinsics, level);
  }

  // What is known of the displacement at a pixel of the rendering: covariance, px^2.
  static Eigen::Matrix2d Predicted(const ViewPair& pair, const Eigen::Vector2d& pixel,
                                   const Eigen::Vector3d& bearing, const CameraUncertainty& uncertainty) {
    constexpr double kUsualDepth = 10.0;  // m, where nothing is seen; from: guard
    float depth = 0.0f;
    if (IsIn(pair.view.depth, pixel)) {
      depth = pair.view.depth.at<float>(static_cast<int>(pixel.y()), static_cast<int>(pixel.x()));
    }
    return DisplacementCovariance(pair.intrinsics, (depth > 0.0f ? depth : kUsualDepth) * bearing,
                                  uncertainty);
  }

  const FeatureMatcher& features_;
};

}  // namespace

std::unique_ptr<ViewMatcher> MakeStructureViewMatcher() { return std::make_unique<StructureViewMatcher>(); }

std::unique_ptr<ViewMatcher> MakeFeatureViewMatcher(const FeatureMatcher& features) {
  return std::make_unique<FeatureViewMatcher>(features);
}

}  // namespace mlic
