#pragma once

#include <cstdint>
#include <limits>
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
  float brightness, weight;       // of its point
  std::int32_t point;
};

// What splats are drawn on, roughly from near to far. Each pixel is the weighted mean of the splats on the
// nearest surface that reaches it: what is farther does not show, and something much nearer that comes late
// replaces what was there.
class SplatCanvas {
 public:
  SplatCanvas(int width, int height)
      : width_(width), height_(height), pixels_(static_cast<std::size_t>(width) * height) {}

  struct Pixel {
    float nearest = std::numeric_limits<float>::infinity();  // m
    float weight = 0.0f, brightness = 0.0f, range = 0.0f;    // sums
    float best_weight = 0.0f;
    std::int32_t best = -1;  // the point with the greatest weight
  };

  // By how much ranges of one surface may differ in a pixel, m.
  static float Tolerance(const Splat& splat) {
    const float slope = (splat.gx < 0.0f ? -splat.gx : splat.gx) + (splat.gy < 0.0f ? -splat.gy : splat.gy);
    return 0.05f + 0.01f * splat.r + 0.5f * slope;
  }

  // Leaves out splats whose middle is hidden.
  void Draw(const Splat& splat);

  const Pixel& pixel(int column, int row) const {
    return pixels_[static_cast<std::size_t>(row) * width_ + column];
  }

 private:
  int width_, height_;
  std::vector<Pixel> pixels_;
};

}  // namespace mlic
