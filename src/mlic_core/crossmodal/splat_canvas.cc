#include "mlic_core/crossmodal/splat_canvas.h"

#include <algorithm>

namespace mlic {
namespace {

// Next integer below and above; for numbers above -4096. std::floor is a call where the processor's own
// instruction may not be used.
int Floor(float x) { return static_cast<int>(x + 4096.0f) - 4096; }
int Ceiling(float x) { return 4096 - static_cast<int>(4096.0f - x); }

}  // namespace

void SplatCanvas::Draw(const Splat& splat) {
  const float tolerance = Tolerance(splat);
  const int middle_column = Floor(splat.u + 0.5f), middle_row = Floor(splat.v + 0.5f);
  if (middle_column >= 0 && middle_row >= 0 && middle_column < width_ && middle_row < height_ &&
      splat.r > pixel(middle_column, middle_row).nearest + tolerance) {
    return;
  }
  const int first_column = std::max(0, Ceiling(splat.u - splat.half_width));
  const int last_column = std::min(width_ - 1, Floor(splat.u + splat.half_width));
  const int first_row = std::max(0, Ceiling(splat.v - splat.half_height));
  const int last_row = std::min(height_ - 1, Floor(splat.v + splat.half_height));
  for (int row = first_row; row <= last_row; ++row) {
    const float y = static_cast<float>(row) - splat.v;
    const float of_row = 1.0f - splat.yy * y * y, mixed = 2.0f * splat.xy * y;
    const float range_of_row = splat.r + splat.gy * y;
    Pixel* const pixels = &pixels_[static_cast<std::size_t>(row) * width_];
    for (int column = first_column; column <= last_column; ++column) {
      const float x = static_cast<float>(column) - splat.u;
      // 1 in the middle, 0 on the border.
      const float inside = of_row - x * (splat.xx * x + mixed);
      if (inside <= 0.0f) continue;
      Pixel& pixel = pixels[column];
      const float range = range_of_row + splat.gx * x;
      if (range > pixel.nearest + tolerance) continue;
      if (range < pixel.nearest - tolerance) pixel = Pixel();
      pixel.nearest = std::min(pixel.nearest, range);
      const float weight = splat.weight * inside * inside;
      pixel.weight += weight;
      pixel.brightness += weight * splat.brightness;
      pixel.range += weight * range;
      if (weight > pixel.best_weight) {
        pixel.best_weight = weight;
        pixel.best = splat.point;
      }
    }
  }
}

}  // namespace mlic
