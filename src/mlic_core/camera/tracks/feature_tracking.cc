#include "mlic_core/camera/tracks/feature_tracking.h"

#include <algorithm>
#include <cmath>
#include <opencv2/video/tracking.hpp>

#include "mlic_core/camera/features/image_quality.h"
#include "mlic_core/common/parallel.h"

namespace mlic {
namespace {

// Keyframes that one task follows: tasks are independent, and tracks that end between them are joined by
// descriptors.
constexpr std::size_t kSegment = 12;  // from: structural, parts of the work

// Better than most matches of descriptors, so joined before them. from: guard, only the order of scores
// counts.
constexpr float kScore = 0.95f;

// Features whose scale is within this ratio show the same blob.
constexpr float kLargestScaleRatio = 1.6f;

struct Followed {
  int feature;            // of the keyframe last passed
  Eigen::Vector2f pixel;  // in the image last looked at
  float scale;
  float angle;
};

// The images of one segment of keyframes, one after the other. Features that are added to a keyframe are kept
// apart, as the next segment reads that keyframe at the same time.
class Segment {
 public:
  Segment(const ImageSource& images, const cv::Mat& mask, const FollowOptions& options)
      : images_(images), mask_(mask), options_(options) {}

  void Start(const Keyframe& keyframe, const FeatureSet& features) {
    followed_.clear();
    flow_.clear();
    Open(keyframe.image);
    Add(features);
  }

  void StepTo(std::size_t image) {
    std::vector<cv::Mat> last = std::move(pyramid_);
    Open(image);
    std::vector<cv::Point2f> from, to;
    for (const Followed& one : followed_) from.emplace_back(one.pixel.x(), one.pixel.y());
    if (from.empty()) return;
    // Features go on as in the last step, which helps in turns.
    for (std::size_t i = 0; i < from.size(); ++i) to.push_back(from[i] + flow_[i]);
    std::vector<std::uint8_t> found;
    std::vector<float> difference;
    cv::calcOpticalFlowPyrLK(last, pyramid_, from, to, found, difference,
                             cv::Size(options_.window, options_.window), options_.levels,
                             cv::TermCriteria(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 20, 0.02),
                             cv::OPTFLOW_USE_INITIAL_FLOW, 1e-3);
    std::vector<Followed> kept;
    std::vector<cv::Point2f> flow;
    for (std::size_t i = 0; i < from.size(); ++i) {
      if (found[i] == 0 || difference[i] > options_.largest_difference || !IsInside(to[i])) continue;
      kept.push_back(followed_[i]);
      kept.back().pixel = {to[i].x, to[i].y};
      flow.push_back(to[i] - from[i]);
    }
    followed_ = std::move(kept);
    flow_ = std::move(flow);
  }

  // Ends at a keyframe and goes on from there. `added` gets features without descriptors.
  std::vector<FeatureMatch> Arrive(const FeatureSet& features, FeatureSet* added) {
    std::vector<FeatureMatch> matches;
    std::vector<bool> taken(features.Count(), false);
    std::vector<Followed> kept;
    std::vector<cv::Point2f> flow;
    for (std::size_t i = 0; i < followed_.size(); ++i) {
      Followed one = followed_[i];
      const int nearest = Nearest(features, one);
      const int origin = one.feature;
      if (nearest >= 0) {
        if (taken[nearest]) continue;
        taken[nearest] = true;
        one = {nearest, features.pixels[nearest], features.scales[nearest], features.angles[nearest]};
      } else {
        one.feature = static_cast<int>(features.Count() + added->Count());
        added->pixels.push_back(one.pixel);
        added->scales.push_back(one.scale);
        added->angles.push_back(one.angle);
        added->scores.push_back(0.0f);
      }
      matches.push_back({origin, one.feature, kScore});
      kept.push_back(one);
      flow.push_back(flow_[i]);
    }
    followed_ = std::move(kept);
    flow_ = std::move(flow);
    Add(features);
    return matches;
  }

 private:
  void Open(std::size_t image) {
    cv::buildOpticalFlowPyramid(ToGray(images_.Load(image)), pyramid_,
                                cv::Size(options_.window, options_.window), options_.levels);
    size_ = pyramid_[0].size();
  }

  bool IsInside(const cv::Point2f& pixel) const {
    const int x = static_cast<int>(std::lround(pixel.x)), y = static_cast<int>(std::lround(pixel.y));
    if (x < 0 || y < 0 || x >= size_.width || y >= size_.height) return false;
    return mask_.empty() || mask_.at<std::uint8_t>(y, x) != 0;
  }

  int Nearest(const FeatureSet& features, const Followed& one) const {
    int nearest = -1;
    float least = static_cast<float>(options_.snap * options_.snap);
    for (std::size_t f = 0; f < features.Count(); ++f) {
      const float square = (features.pixels[f] - one.pixel).squaredNorm();
      const float ratio = features.scales[f] / one.scale;
      if (square > least || ratio > kLargestScaleRatio || ratio * kLargestScaleRatio < 1.0f) continue;
      least = square;
      nearest = static_cast<int>(f);
    }
    return nearest;
  }

  // Fills up with features of the keyframe that are far enough from those already followed, spread over the
  // image.
  void Add(const FeatureSet& features) {
    const float least = 0.6f * static_cast<float>(options_.window);
    std::vector<Eigen::Vector2f> pixels;
    std::vector<float> scores;
    std::vector<int> of;
    for (std::size_t f = 0; f < features.Count(); ++f) {
      const auto near = [&](const Followed& one) {
        return (one.pixel - features.pixels[f]).squaredNorm() < least * least;
      };
      if (std::any_of(followed_.begin(), followed_.end(), near)) continue;
      pixels.push_back(features.pixels[f]);
      scores.push_back(features.scores[f]);
      of.push_back(static_cast<int>(f));
    }
    const int room = std::max(0, options_.most_features - static_cast<int>(followed_.size()));
    for (const int i : SpreadOverImage(pixels, scores, size_.width, size_.height, 12, room)) {
      const int f = of[i];
      followed_.push_back({f, features.pixels[f], features.scales[f], features.angles[f]});
      flow_.emplace_back(0.0f, 0.0f);
    }
  }

  const ImageSource& images_;
  const cv::Mat& mask_;
  const FollowOptions& options_;
  std::vector<cv::Mat> pyramid_;
  cv::Size size_;
  std::vector<Followed> followed_;
  std::vector<cv::Point2f> flow_;  // of the last step
};

void Append(const FeatureSet& added, FeatureSet* features) {
  features->pixels.insert(features->pixels.end(), added.pixels.begin(), added.pixels.end());
  features->scales.insert(features->scales.end(), added.scales.begin(), added.scales.end());
  features->angles.insert(features->angles.end(), added.angles.begin(), added.angles.end());
  features->scores.insert(features->scores.end(), added.scores.begin(), added.scores.end());
  const std::size_t size = features->Count() * static_cast<std::size_t>(features->descriptor_size);
  if (!features->descriptors.empty()) features->descriptors.resize(size, 0);
  if (!features->float_descriptors.empty()) features->float_descriptors.resize(size, 0.0f);
}

}  // namespace

std::vector<PairMatches> FollowFeatures(const ImageSource& images, const cv::Mat& mask,
                                        const std::vector<Keyframe>& keyframes, const KeyframeRange& range,
                                        const FollowOptions& options, std::vector<FeatureSet>* features,
                                        const CancellationToken* cancellation) {
  const std::size_t first = range.first, last = range.last;
  if (last < first + 2) return {};
  const std::size_t steps = last - first - 1;
  std::vector<PairMatches> matches(steps);
  std::vector<FeatureSet> added(steps);  // to keyframe first + step + 1
  ParallelFor((steps + kSegment - 1) / kSegment, [&](std::size_t s) {
    Segment segment(images, mask, options);
    const std::size_t begin = s * kSegment, end = std::min(steps, begin + kSegment);
    segment.Start(keyframes[first + begin], (*features)[first + begin]);
    for (std::size_t step = begin; step < end; ++step) {
      const Keyframe &from = keyframes[first + step], &to = keyframes[first + step + 1];
      if (to.time - from.time > options.largest_interval) {
        segment.Start(to, (*features)[first + step + 1]);
        continue;
      }
      for (std::size_t image = from.image + 1; image <= to.image; ++image) {
        if (cancellation != nullptr) cancellation->ThrowIfCancelled();
        segment.StepTo(image);
      }
      matches[step].keyframe_a = static_cast<std::int32_t>(first + step);
      matches[step].keyframe_b = static_cast<std::int32_t>(first + step + 1);
      matches[step].matches = segment.Arrive((*features)[first + step + 1], &added[step]);
    }
  });
  for (std::size_t step = 0; step < steps; ++step) Append(added[step], &(*features)[first + step + 1]);
  const auto empty = [](const PairMatches& pair) { return pair.matches.empty(); };
  matches.erase(std::remove_if(matches.begin(), matches.end(), empty), matches.end());
  return matches;
}

}  // namespace mlic
