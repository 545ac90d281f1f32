#include "mlic_core/camera/learned/learned_detection.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "mlic_core/common/error.h"

namespace mlic {
namespace {

constexpr int kDescriptorSize = 256;  // from: standard, SuperPoint
constexpr int kCell = 8;  // SuperPoint's network divides the image by 8; from: standard, SuperPoint

// Sigma of the structure about a keypoint, px of the working image: decides the size of the patches by which
// tracks are refined, and stands for the keypoint's own error of about half a pixel (whole pixels, and
// noise). from: derivation, 0.25 px for each px of scale (TracksOfFeatures) make that half pixel.
constexpr float kScale = 2.2f;

// The network's image: made smaller where needed, and continued to the right and below with its last pixels
// to the size that the network takes.
struct WorkingImage {
  Tensor tensor;
  float scale_x = 1.0f, scale_y = 1.0f;  // pixels of the working image for each of the original

  // Both images' outer edges coincide, and pixel centres are at integers: so the halves.
  Eigen::Vector2f ToOriginal(float x, float y) const {
    return {(x + 0.5f) / scale_x - 0.5f, (y + 0.5f) / scale_y - 0.5f};
  }
};

int RoundUp(int size) { return (size + kCell - 1) / kCell * kCell; }

WorkingImage PrepareImage(const cv::Mat& gray, const Network& detector, int longest_side) {
  double scale = std::min(1.0, static_cast<double>(longest_side) / std::max(gray.cols, gray.rows));
  const std::vector<std::int64_t> shape = detector.DeclaredShape(0);
  const int fixed_height = shape.size() == 4 && shape[2] > 0 ? static_cast<int>(shape[2]) : 0;
  const int fixed_width = shape.size() == 4 && shape[3] > 0 ? static_cast<int>(shape[3]) : 0;
  if (fixed_width > 0) scale = std::min(scale, static_cast<double>(fixed_width) / gray.cols);
  if (fixed_height > 0) scale = std::min(scale, static_cast<double>(fixed_height) / gray.rows);

  cv::Mat values;
  gray.convertTo(values, CV_32F, 1.0 / 255.0);
  const int width = std::max(1, static_cast<int>(std::lround(gray.cols * scale)));
  const int height = std::max(1, static_cast<int>(std::lround(gray.rows * scale)));
  if (width != gray.cols || height != gray.rows) {
    cv::resize(values, values, cv::Size(width, height), 0.0, 0.0, cv::INTER_AREA);
  }
  const int full_width = fixed_width > 0 ? fixed_width : RoundUp(width);
  const int full_height = fixed_height > 0 ? fixed_height : RoundUp(height);
  cv::copyMakeBorder(values, values, 0, full_height - height, 0, full_width - width, cv::BORDER_REPLICATE);

  WorkingImage image;
  image.scale_x = static_cast<float>(width) / static_cast<float>(gray.cols);
  image.scale_y = static_cast<float>(height) / static_cast<float>(gray.rows);
  image.tensor.shape = {1, 1, full_height, full_width};
  image.tensor.values.assign(values.ptr<float>(), values.ptr<float>() + values.total());
  return image;
}

std::string ShapeText(const Tensor& tensor) {
  std::string text;
  for (const std::int64_t size : tensor.shape) text += (text.empty() ? "" : ", ") + std::to_string(size);
  return "[" + text + "]";
}

// Whether the shape is [1, count, columns] or [count, columns]; columns 1: [1, count] or [count].
bool HasShape(const Tensor& tensor, std::int64_t count, std::int64_t columns) {
  std::vector<std::int64_t> shape = {count};
  if (columns > 1) shape.push_back(columns);
  if (tensor.shape == shape) return true;
  shape.insert(shape.begin(), 1);
  return tensor.shape == shape;
}

void CheckOutputs(const std::vector<Tensor>& outputs, const std::string& file) {
  const auto count = static_cast<std::int64_t>(outputs[1].values.size());
  if (HasShape(outputs[0], count, 2) && HasShape(outputs[1], count, 1) &&
      HasShape(outputs[2], count, kDescriptorSize)) {
    return;
  }
  throw InputError(
      file +
      ": keypoints, scores, descriptors must have the shapes [1, N, 2], [1, N], [1, N, 256], and "
      "have " +
      ShapeText(outputs[0]) + ", " + ShapeText(outputs[1]) + ", " + ShapeText(outputs[2]));
}

}  // namespace

NetworkSignature DetectorSignature() {
  return {{{{"image"}, {1, 1, kAnyOrFixed, kAnyOrFixed}}},
          {{{"keypoints"}, {}}, {{"scores"}, {}}, {{"descriptors"}, {}}}};
}

FeatureSet DetectLearned(const Network& detector, const std::string& file, const cv::Mat& gray,
                         const cv::Mat& mask, const LearnedDetectionOptions& options) {
  Check(gray.type() == CV_8UC1, "DetectLearned: the image is CV_8UC1");
  Check(mask.empty() || mask.size() == gray.size(), "DetectLearned: the mask has the image's size");
  const WorkingImage image = PrepareImage(gray, detector, options.longest_side);
  const std::vector<Tensor> outputs = detector.Run({image.tensor});
  CheckOutputs(outputs, file);

  const cv::Mat allowed = AllowedPixels(mask, gray.size(), options.border);
  const std::vector<float>&keypoints = outputs[0].values, &all_scores = outputs[1].values;
  std::vector<Eigen::Vector2f> pixels;
  std::vector<float> scores;
  std::vector<std::size_t> rows;  // of the network's descriptors
  for (std::size_t i = 0; i < all_scores.size(); ++i) {
    const Eigen::Vector2f pixel = image.ToOriginal(keypoints[2 * i], keypoints[2 * i + 1]);
    const long x = std::lround(pixel.x()), y = std::lround(pixel.y());
    if (x < 0 || y < 0 || x >= gray.cols || y >= gray.rows) continue;
    if (allowed.at<std::uint8_t>(static_cast<int>(y), static_cast<int>(x)) == 0) continue;
    pixels.push_back(pixel);
    scores.push_back(all_scores[i]);
    rows.push_back(i);
  }

  FeatureSet features;
  features.width = gray.cols;
  features.height = gray.rows;
  features.descriptor_size = kDescriptorSize;
  for (const int k :
       SpreadOverImage(pixels, scores, gray.cols, gray.rows, options.grid, options.most_features)) {
    features.pixels.push_back(pixels[k]);
    features.scales.push_back(kScale / std::min(image.scale_x, image.scale_y));
    features.angles.push_back(0.0f);
    features.scores.push_back(scores[k]);
    const auto descriptor =
        outputs[2].values.begin() + static_cast<std::ptrdiff_t>(rows[k] * kDescriptorSize);
    features.float_descriptors.insert(features.float_descriptors.end(), descriptor,
                                      descriptor + kDescriptorSize);
  }
  return features;
}

}  // namespace mlic
