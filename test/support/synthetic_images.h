#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <utility>
#include <vector>

#include "mlic_core/common/random.h"
#include "mlic_core/sensors/images.h"

namespace mlic {

// A plane texture known at every real coordinate (px), with structure of 2 to 60 px: blobs with soft edges on
// smooth noise. Images of it under a known warp have known correspondences.
class SyntheticTexture {
 public:
  explicit SyntheticTexture(std::uint64_t seed) : seed_(seed) {}

  double At(double x, double y) const {
    double value = 0.0;
    for (int octave = 0; octave < 5; ++octave) {
      const double size = 48.0 / (1 << octave);
      const double noise = Noise(x / size + 17.3 * octave, y / size - 9.1 * octave, octave);
      // Steep where it crosses zero: edges of patches, as surfaces have them.
      value += std::tanh(3.0 * noise) * std::pow(0.8, octave);
    }
    return 128.0 + 32.0 * value;
  }

 private:
  double Lattice(std::int64_t x, std::int64_t y, int octave) const {
    Random random(seed_ + 0x9E37ull * octave + 0x85EBCA6Bull * static_cast<std::uint64_t>(x) +
                  0xC2B2AE3D27D4EB4Full * static_cast<std::uint64_t>(y));
    return random.Uniform(-1.0, 1.0);
  }
  double Noise(double x, double y, int octave) const {
    const double fx = std::floor(x), fy = std::floor(y);
    const auto ix = static_cast<std::int64_t>(fx), iy = static_cast<std::int64_t>(fy);
    const auto fade = [](double t) { return t * t * t * (t * (6.0 * t - 15.0) + 10.0); };
    const double u = fade(x - fx), v = fade(y - fy);
    const double top = (1.0 - u) * Lattice(ix, iy, octave) + u * Lattice(ix + 1, iy, octave);
    const double bottom = (1.0 - u) * Lattice(ix, iy + 1, octave) + u * Lattice(ix + 1, iy + 1, octave);
    return (1.0 - v) * top + v * bottom;
  }

  std::uint64_t seed_;
};

// Image whose pixel p shows texture at warp(p), the mean over the pixel's area; normal noise of that sigma
// (gray values) is added. Pixels where warp gives NaN are black.
inline cv::Mat RenderTexture(const SyntheticTexture& texture, int width, int height,
                             const std::function<Eigen::Vector2d(const Eigen::Vector2d&)>& warp, double noise,
                             std::uint64_t seed) {
  cv::Mat image(height, width, CV_8UC1);
  Random random(seed);
  constexpr int kSamples = 3;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      double sum = 0.0;
      for (int s = 0; s < kSamples * kSamples; ++s) {
        const Eigen::Vector2d p(x + (s % kSamples + 0.5) / kSamples - 0.5,
                                y + (s / kSamples + 0.5) / kSamples - 0.5);
        const Eigen::Vector2d q = warp(p);
        sum += std::isnan(q.x()) ? 0.0 : texture.At(q.x(), q.y());
      }
      const double value = sum / (kSamples * kSamples) + noise * random.Normal();
      image.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(std::clamp(std::lround(value), 0L, 255L));
    }
  }
  return image;
}

// Images held in memory, ten each second.
class MemoryImages : public ImageSource {
 public:
  explicit MemoryImages(std::vector<cv::Mat> images) : images_(std::move(images)) {}
  std::size_t Count() const override { return images_.size(); }
  double Time(std::size_t index) const override { return 0.1 * static_cast<double>(index); }
  cv::Mat Load(std::size_t index) const override { return images_[index]; }

 private:
  std::vector<cv::Mat> images_;
};

}  // namespace mlic
