#include "mlic_core/crossmodal/hole_filling.h"

#include <algorithm>
#include <vector>

namespace mlic {
namespace {

constexpr int kFarthest = 16;      // px
constexpr float kSpacings = 3.0f;  // a gap's half width over the spacing of the points

// A seen pixel in one of the four directions, and its distance.
struct Neighbour {
  int pixel;
  int distance;
};

class HoleFiller {
 public:
  HoleFiller(const IntensityMap& map, double pixels_per_radian, RenderedView* view)
      : map_(map),
        pixels_per_radian_(static_cast<float>(pixels_per_radian)),
        view_(view),
        width_(view->depth.cols),
        height_(view->depth.rows),
        seen_(view->point.clone()) {}

  void Run() {
    FindAbove();
    // Bottom to top, so that the distance to the next seen pixel below is known as well.
    std::vector<int> below(width_, kFarthest + 1);
    std::vector<int> right(width_);
    for (int row = height_ - 1; row >= 0; --row) {
      const std::int32_t* points = seen_.ptr<std::int32_t>(row);
      int next = kFarthest + 1;
      for (int column = width_ - 1; column >= 0; --column) {
        next = points[column] >= 0 ? 0 : std::min(next + 1, kFarthest + 1);
        right[column] = next;
      }
      int left = kFarthest + 1;
      for (int column = 0; column < width_; ++column) {
        const bool is_seen = points[column] >= 0;
        left = is_seen ? 0 : std::min(left + 1, kFarthest + 1);
        below[column] = is_seen ? 0 : std::min(below[column] + 1, kFarthest + 1);
        const int above = above_[row * width_ + column];
        if (is_seen || std::max({left, right[column], above, below[column]}) > kFarthest) continue;
        Fill(row, column, left, right[column], above, below[column]);
      }
    }
  }

 private:
  void FindAbove() {
    above_.assign(static_cast<std::size_t>(width_) * height_, kFarthest + 1);
    for (int row = 0; row < height_; ++row) {
      const std::int32_t* points = seen_.ptr<std::int32_t>(row);
      for (int column = 0; column < width_; ++column) {
        const int before = row > 0 ? above_[(row - 1) * width_ + column] : kFarthest;
        above_[row * width_ + column] =
            static_cast<std::uint8_t>(points[column] >= 0 ? 0 : std::min(before + 1, kFarthest + 1));
      }
    }
  }

  template <typename T>
  T& At(cv::Mat& image, int pixel) const {
    return reinterpret_cast<T*>(image.data)[pixel];
  }

  // Whether the neighbour is of a surface with gaps as wide as this.
  bool MayHaveGap(const Neighbour& neighbour) const {
    const SurfacePoint& point = map_.points[At<std::int32_t>(seen_, neighbour.pixel)];
    if (point.normal.isZero()) return false;
    const float depth = At<float>(view_->depth, neighbour.pixel);
    return neighbour.distance <= 2.0f + kSpacings * point.spacing / depth * pixels_per_radian_;
  }

  void Fill(int row, int column, int left, int right, int above, int below) {
    const int pixel = row * width_ + column;
    const Neighbour neighbours[4] = {{pixel - left, left},
                                     {pixel + right, right},
                                     {pixel - above * width_, above},
                                     {pixel + below * width_, below}};
    float nearest = 1e9f, farthest = 0.0f;
    for (const Neighbour& n : neighbours) {
      if (!MayHaveGap(n)) return;
      nearest = std::min(nearest, At<float>(view_->depth, n.pixel));
      farthest = std::max(farthest, At<float>(view_->depth, n.pixel));
    }
    if (farthest > 0.1f + 1.15f * nearest) return;
    float weights = 0.0f, intensity = 0.0f, depth = 0.0f;
    const Neighbour* closest = &neighbours[0];
    for (int k = 0; k < 4; ++k) {
      const Neighbour& n = neighbours[k];
      // Opposite ones together interpolate linearly; the nearer pair counts more.
      const float span = static_cast<float>(n.distance + neighbours[k ^ 1].distance);
      const float weight = static_cast<float>(neighbours[k ^ 1].distance) / (span * span);
      weights += weight;
      intensity += weight * At<float>(view_->intensity, n.pixel);
      depth += weight * At<float>(view_->depth, n.pixel);
      if (n.distance < closest->distance) closest = &n;
    }
    At<float>(view_->intensity, pixel) = intensity / weights;
    At<float>(view_->depth, pixel) = depth / weights;
    At<cv::Vec3f>(view_->normal, pixel) = At<cv::Vec3f>(view_->normal, closest->pixel);
    At<std::int32_t>(view_->point, pixel) = At<std::int32_t>(seen_, closest->pixel);
    At<float>(view_->spacing, pixel) = At<float>(view_->spacing, closest->pixel);
  }

  const IntensityMap& map_;
  const float pixels_per_radian_;
  RenderedView* view_;
  const int width_, height_;
  mutable cv::Mat seen_;             // the points before anything was filled
  std::vector<std::uint8_t> above_;  // px to the next seen pixel above
};

}  // namespace

void FillHoles(const IntensityMap& map, double pixels_per_radian, RenderedView* view) {
  HoleFiller(map, pixels_per_radian, view).Run();
}

}  // namespace mlic
