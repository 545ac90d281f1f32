#include "mlic_core/camera/tracks/static_mask.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "mlic_core/camera/features/image_quality.h"
#include "mlic_core/common/order_statistics.h"
#include "mlic_core/common/parallel.h"

namespace mlic {
namespace {

// Images are compared at a quarter of their size: a body's edge moves a little with vibration, and noise
// averages out.
constexpr int kReduction = 4;

// Spread over time, as a share of the spread's usual value in the image, below which a pixel does not change.
constexpr double kSmallAgainstOthers = 0.25;

// For each pixel half the range between the 15th and the 85th percentile over time, after the changes of
// exposure have been divided out: about one standard deviation.
cv::Mat SpreadOverTime(const std::vector<cv::Mat>& images) {
  const std::size_t count = images.size();
  cv::Mat spread(images[0].size(), CV_32FC1);
  const std::size_t low = count * 15 / 100, high = count - 1 - low;
  ParallelFor(static_cast<std::size_t>(spread.rows), [&](std::size_t y) {
    std::vector<float> values(count);
    for (int x = 0; x < spread.cols; ++x) {
      for (std::size_t i = 0; i < count; ++i) values[i] = images[i].at<float>(static_cast<int>(y), x);
      std::nth_element(values.begin(), values.begin() + low, values.end());
      const float small = values[low];
      std::nth_element(values.begin(), values.begin() + high, values.end());
      spread.at<float>(static_cast<int>(y), x) = 0.5f * (values[high] - small);
    }
  });
  return spread;
}

// Sets regions of `same` (CV_8UC1) with fewer than `least` pixels to 0.
void RemoveSmallRegions(double least, cv::Mat* same) {
  cv::Mat labels, statistics, centres;
  const int count = cv::connectedComponentsWithStats(*same, labels, statistics, centres, 8, CV_32S);
  for (int label = 1; label < count; ++label) {
    if (statistics.at<int>(label, cv::CC_STAT_AREA) < least) same->setTo(0, labels == label);
  }
}

}  // namespace

cv::Mat FindStaticPixels(const CameraRecording& recording, const std::vector<Keyframe>& keyframes,
                         const StaticMaskOptions& options, const CancellationToken* cancellation) {
  cv::Mat allowed;
  if (recording.mask.empty()) {
    allowed = cv::Mat(recording.height, recording.width, CV_8UC1, cv::Scalar(255));
  } else {
    allowed = recording.mask != 0;
  }
  constexpr std::size_t kFewest = 8;  // from: guard
  if (keyframes.size() < kFewest) return allowed;

  const std::size_t count = std::min<std::size_t>(keyframes.size(), std::max(options.images, 1));
  std::vector<cv::Mat> images(count);
  ParallelFor(count, [&](std::size_t i) {
    if (cancellation != nullptr) cancellation->ThrowIfCancelled();
    const Keyframe& keyframe = keyframes[i * (keyframes.size() - 1) / std::max<std::size_t>(1, count - 1)];
    const cv::Mat gray = ToGray(recording.images->Load(keyframe.image));
    cv::resize(gray, images[i], cv::Size(gray.cols / kReduction, gray.rows / kReduction), 0, 0,
               cv::INTER_AREA);
    images[i].convertTo(images[i], CV_32F);
  });
  const cv::Mat spread = SpreadOverTime(images);
  const double limit =
      std::min(options.largest_deviation,
               kSmallAgainstOthers * Median(std::vector<float>(spread.begin<float>(), spread.end<float>())));
  cv::Mat same = spread < limit;
  // Texture that moves across a pixel changes it; what is plain (sky, asphalt) may not change either, and
  // loses nothing by being left out: it has no features.
  cv::morphologyEx(same, same, cv::MORPH_OPEN, cv::Mat::ones(3, 3, CV_8UC1));
  cv::morphologyEx(same, same, cv::MORPH_CLOSE, cv::Mat::ones(5, 5, CV_8UC1));
  RemoveSmallRegions(options.least_share * same.total(), &same);
  cv::Mat full;
  cv::resize(same, full, allowed.size(), 0, 0, cv::INTER_NEAREST);
  const int side = 2 * options.margin + 1;
  cv::dilate(full, full, cv::Mat::ones(side, side, CV_8UC1));
  allowed.setTo(0, full);
  return allowed;
}

}  // namespace mlic
