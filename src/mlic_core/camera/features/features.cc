#include "mlic_core/camera/features/features.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <tuple>

#include "mlic_core/common/error.h"

namespace mlic {
namespace {

// OpenCV doubles the image by cv::resize, which puts pixel i of the double at i/2 - 1/4 of the image, but
// SIFT reads it as i/2: its features lie a quarter of a pixel too far right and down.
// test/camera_features_test.cc measures it.
constexpr float kSiftShift = 0.25f;  // from: measured

// OpenCV's KeyPoint::size is the diameter 2 * sigma.
constexpr float kSigmaOfSize = 0.5f;  // from: standard

}  // namespace

cv::Mat AllowedPixels(const cv::Mat& mask, const cv::Size& size, int border) {
  cv::Mat allowed(size, CV_8UC1, cv::Scalar(0));
  const cv::Rect inner(border, border, size.width - 2 * border, size.height - 2 * border);
  if (inner.width <= 0 || inner.height <= 0) return allowed;
  if (mask.empty()) {
    allowed(inner).setTo(255);
  } else {
    cv::Mat eroded;
    cv::erode(mask, eroded, cv::Mat::ones(2 * border + 1, 2 * border + 1, CV_8UC1));
    eroded(inner).copyTo(allowed(inner));
  }
  return allowed;
}

std::vector<int> SpreadOverImage(const std::vector<Eigen::Vector2f>& pixels, const std::vector<float>& scores,
                                 int width, int height, int grid, int most) {
  const double cell = std::max(1.0, std::max(width, height) / static_cast<double>(std::max(1, grid)));
  const int columns = static_cast<int>(width / cell) + 1, rows = static_cast<int>(height / cell) + 1;
  std::vector<int> order(pixels.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return scores[a] > scores[b]; });
  std::vector<int> taken(static_cast<std::size_t>(columns) * rows, 0);
  std::vector<std::pair<int, int>> rank_and_place;  // rank within the cell, place in order
  rank_and_place.reserve(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) {
    const Eigen::Vector2f& pixel = pixels[order[k]];
    const int column = std::clamp(static_cast<int>(pixel.x() / cell), 0, columns - 1);
    const int row = std::clamp(static_cast<int>(pixel.y() / cell), 0, rows - 1);
    rank_and_place.emplace_back(taken[row * columns + column]++, static_cast<int>(k));
  }
  std::sort(rank_and_place.begin(), rank_and_place.end());
  std::vector<int> chosen;
  for (const auto& entry : rank_and_place) {
    if (static_cast<int>(chosen.size()) >= most) break;
    chosen.push_back(order[entry.second]);
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

FeatureSet DetectSift(const cv::Mat& gray, const cv::Mat& mask, const FeatureOptions& options) {
  Check(gray.type() == CV_8UC1, "DetectSift: the image is CV_8UC1");
  Check(mask.empty() || mask.size() == gray.size(), "DetectSift: the mask has the image's size");
  const cv::Mat allowed = AllowedPixels(mask, gray.size(), options.border);
  // Descriptors cost most, so only the strongest get one, with a reserve for the grid to choose from.
  const auto sift =
      cv::SIFT::create(2 * options.most_features, 3, options.contrast_threshold, 10.0, 1.6, CV_8U);
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;
  sift->detectAndCompute(gray, allowed, keypoints, descriptors);

  std::vector<int> order(keypoints.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int a, int b) {
    const cv::KeyPoint &p = keypoints[a], &q = keypoints[b];
    return std::make_tuple(p.pt.y, p.pt.x, p.size, p.angle, p.response, a) <
           std::make_tuple(q.pt.y, q.pt.x, q.size, q.angle, q.response, b);
  });
  std::vector<Eigen::Vector2f> pixels;
  std::vector<float> scores;
  for (const int i : order) {
    pixels.emplace_back(keypoints[i].pt.x - kSiftShift, keypoints[i].pt.y - kSiftShift);
    scores.push_back(keypoints[i].response);
  }
  FeatureSet features;
  features.descriptor_size = 128;
  for (const int k :
       SpreadOverImage(pixels, scores, gray.cols, gray.rows, options.grid, options.most_features)) {
    const cv::KeyPoint& keypoint = keypoints[order[k]];
    features.pixels.push_back(pixels[k]);
    features.scales.push_back(kSigmaOfSize * keypoint.size);
    features.angles.push_back(keypoint.angle * static_cast<float>(M_PI / 180.0));
    features.scores.push_back(keypoint.response);
    const std::uint8_t* descriptor = descriptors.ptr<std::uint8_t>(order[k]);
    features.descriptors.insert(features.descriptors.end(), descriptor, descriptor + 128);
  }
  return features;
}

}  // namespace mlic
