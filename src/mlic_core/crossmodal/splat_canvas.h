#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace mlic {

// A small ellipse of a surface in the image. A pixel at (x, y) from its middle belongs to it where
// xx x^2 + 2 xy x y + yy y^2 < 1, and is seen at the range r + gx x + gy y.
struct Splat {
  float u, v;  // px
  float r;     // m
  float xx, xy, yy;
  float gx, gy;                   // m/px
  float half_width, half_height;  // px, of the box around it
  std::uint32_t point;
};

// What splats are drawn on: first their ranges, so that each pixel knows its nearest surface, then the
// brightness of those that lie on it.
class SplatCanvas {
 public:
  SplatCanvas(int width, int height);

  // By how much ranges of one surface may differ in a pixel, m.
  static float Tolerance(const Splat& splat) {
    const float slope = (splat.gx < 0.0f ? -splat.gx : splat.gx) + (splat.gy < 0.0f ? -splat.gy : splat.gy);
    return 0.05f + 0.01f * splat.r + 0.5f * slope;
  }

  // Whether something much nearer than the range has been drawn there.
  bool IsHidden(float u, float v, float range, float tolerance) const {
    const int column = static_cast<int>(u + 0.5f), row = static_cast<int>(v + 0.5f);
    if (column < 0 || row < 0 || column >= width_ || row >= height_) return false;
    return nearest_[static_cast<std::size_t>(row) * width_ + column] < range - tolerance;
  }

  void DrawRange(const Splat& splat);
  void DrawBrightness(const Splat& splat, float brightness, float weight);

  int width() const { return width_; }
  int height() const { return height_; }
  float nearest(std::size_t pixel) const { return nearest_[pixel]; }

  struct Sum {
    float weight = 0.0f, brightness = 0.0f, range = 0.0f, best_weight = 0.0f;
    std::int32_t best = -1;
  };
  const std::vector<Sum>& sums() const { return sums_; }

 private:
  int width_, height_;
  std::vector<float> nearest_;
  std::vector<Sum> sums_;
};

}  // namespace mlic
