#include "mlic_core/crossmodal/splat_canvas.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace mlic {
namespace {

// Calls body(pixel, inside, range) for the pixels of a splat; inside: 1 in the middle, 0 on the border.
template <typename Body>
void ForPixels(const Splat& splat, int width, int height, const Body& body) {
  const int first_column = std::max(0, static_cast<int>(std::ceil(splat.u - splat.half_width)));
  const int last_column = std::min(width - 1, static_cast<int>(std::floor(splat.u + splat.half_width)));
  const int first_row = std::max(0, static_cast<int>(std::ceil(splat.v - splat.half_height)));
  const int last_row = std::min(height - 1, static_cast<int>(std::floor(splat.v + splat.half_height)));
  for (int row = first_row; row <= last_row; ++row) {
    const float y = row - splat.v;
    for (int column = first_column; column <= last_column; ++column) {
      const float x = column - splat.u;
      const float inside = 1.0f - (splat.xx * x * x + 2.0f * splat.xy * x * y + splat.yy * y * y);
      if (inside <= 0.0f) continue;
      body(static_cast<std::size_t>(row) * width + column, inside, splat.r + splat.gx * x + splat.gy * y);
    }
  }
}

}  // namespace

SplatCanvas::SplatCanvas(int width, int height)
    : width_(width),
      height_(height),
      nearest_(static_cast<std::size_t>(width) * height, std::numeric_limits<float>::infinity()),
      sums_(nearest_.size()) {}

void SplatCanvas::DrawRange(const Splat& splat) {
  ForPixels(splat, width_, height_, [&](std::size_t pixel, float, float range) {
    nearest_[pixel] = std::min(nearest_[pixel], range);
  });
}

void SplatCanvas::DrawBrightness(const Splat& splat, float brightness, float point_weight) {
  const float tolerance = Tolerance(splat);
  ForPixels(splat, width_, height_, [&](std::size_t pixel, float inside, float range) {
    if (range > nearest_[pixel] + tolerance) return;
    const float weight = point_weight * inside * inside;
    Sum& sum = sums_[pixel];
    sum.weight += weight;
    sum.brightness += weight * brightness;
    sum.range += weight * range;
    if (weight > sum.best_weight) {
      sum.best_weight = weight;
      sum.best = static_cast<std::int32_t>(splat.point);
    }
  });
}

}  // namespace mlic
