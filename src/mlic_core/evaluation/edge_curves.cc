#include "mlic_core/evaluation/edge_curves.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "mlic_core/common/order_statistics.h"

namespace mlic {
namespace {

// Constants of this file, from: definition of the figure of merit.

using Eigen::Vector2d;

constexpr double kSmoothing = 1.0;  // px, of the image before its gradient is taken
// Edges are at least so strong, as a share of what the strongest hundredth of the pixels has.
constexpr double kStrongest = 0.99, kLeastShare = 0.25;
constexpr int kReach = 2;              // px, to the next place of a curve
constexpr double kMostTurn = 0.5;      // rad, of the gradient from one place to the next
constexpr std::size_t kTurnOver = 8;   // places, over which
constexpr double kMostTurnOver = 0.4;  // rad, it turns by less

struct EdgeMap {
  int width, height;
  std::vector<Vector2d> place;      // of each pixel that holds one
  std::vector<Vector2d> direction;  // unit, of its gradient; zero: the pixel holds no place
  std::size_t At(int u, int v) const { return static_cast<std::size_t>(v * width + u); }
  bool Holds(std::size_t pixel) const { return !direction[pixel].isZero(); }
};

// Where a parabola through three equidistant values, the middle one the largest, has its top; from -0.5 to
// 0.5.
double Top(double before, double middle, double after) {
  return 0.5 * (before - after) / (before - 2.0 * middle + after);
}

EdgeMap FindPlaces(const cv::Mat& image) {
  cv::Mat smooth, gx, gy, size;
  image.convertTo(smooth, CV_32F);
  cv::GaussianBlur(smooth, smooth, {}, kSmoothing);
  const cv::Mat central = (cv::Mat_<float>(1, 3) << -0.5f, 0.0f, 0.5f);
  cv::filter2D(smooth, gx, CV_32F, central);
  cv::filter2D(smooth, gy, CV_32F, central.t());
  cv::magnitude(gx, gy, size);
  const float least = static_cast<float>(kLeastShare) *
                      Quantile(std::vector<float>(size.begin<float>(), size.end<float>()), kStrongest);
  EdgeMap map{image.cols, image.rows, {}, {}};
  map.place.resize(static_cast<std::size_t>(image.cols * image.rows), Vector2d::Zero());
  map.direction = map.place;
  for (int v = 1; v + 1 < image.rows; ++v) {
    for (int u = 1; u + 1 < image.cols; ++u) {
      const float middle = size.at<float>(v, u);
      if (!(middle > least)) continue;
      const float x = gx.at<float>(v, u), y = gy.at<float>(v, u);
      const bool across = std::abs(x) >= std::abs(y);
      const float before = across ? size.at<float>(v, u - 1) : size.at<float>(v - 1, u);
      const float after = across ? size.at<float>(v, u + 1) : size.at<float>(v + 1, u);
      if (before >= middle || after > middle) continue;
      const double top = Top(before, middle, after);
      map.place[map.At(u, v)] = Vector2d(u + (across ? top : 0.0), v + (across ? 0.0 : top));
      map.direction[map.At(u, v)] = Vector2d(x, y).normalized();
    }
  }
  return map;
}

// Follows edges from place to place, each of which belongs to one curve.
class Tracer {
 public:
  explicit Tracer(const EdgeMap& map) : map_(map), taken_(map.place.size(), false) {}

  bool IsFree(std::size_t pixel) const { return map_.Holds(pixel) && !taken_[pixel]; }

  // The curve through a free place, from one end to the other.
  EdgeCurve Trace(std::size_t seed) {
    taken_[seed] = true;
    const std::vector<std::size_t> back = Follow(seed, -1.0), forth = Follow(seed, 1.0);
    EdgeCurve curve;
    for (auto pixel = back.rbegin(); pixel != back.rend(); ++pixel) curve.push_back(map_.place[*pixel]);
    for (const std::size_t pixel : forth) {
      if (pixel != seed) curve.push_back(map_.place[pixel]);
    }
    return curve;
  }

 private:
  // The pixels from the seed on with the bright side to the left (side 1) or to the right (-1).
  std::vector<std::size_t> Follow(std::size_t seed, double side) {
    std::vector<std::size_t> pixels = {seed};
    while (true) {
      const std::size_t next = Next(pixels, side);
      if (next == seed) return pixels;
      taken_[next] = true;
      pixels.push_back(next);
    }
  }

  // The nearest free place ahead; the first of the pixels where there is none.
  std::size_t Next(const std::vector<std::size_t>& pixels, double side) const {
    const Vector2d& here = map_.place[pixels.back()];
    const Vector2d& gradient = map_.direction[pixels.back()];
    const Vector2d& earlier = map_.direction[pixels[pixels.size() - std::min(pixels.size(), kTurnOver)]];
    const Vector2d ahead(-side * gradient.y(), side * gradient.x());
    const int u = static_cast<int>(std::lround(here.x())), v = static_cast<int>(std::lround(here.y()));
    std::size_t best = pixels.front();
    double nearest = kReach + 1.0;
    for (int y = std::max(0, v - kReach); y <= std::min(map_.height - 1, v + kReach); ++y) {
      for (int x = std::max(0, u - kReach); x <= std::min(map_.width - 1, u + kReach); ++x) {
        const std::size_t pixel = map_.At(x, y);
        if (!IsFree(pixel)) continue;
        const Vector2d step = map_.place[pixel] - here;
        // A step that leads away from the edge's direction belongs to another edge.
        if (step.norm() >= nearest || step.dot(ahead) < 0.7 * step.norm()) continue;
        if (map_.direction[pixel].dot(gradient) < std::cos(kMostTurn) ||
            map_.direction[pixel].dot(earlier) < std::cos(kMostTurnOver)) {
          continue;
        }
        nearest = step.norm();
        best = pixel;
      }
    }
    return best;
  }

  const EdgeMap& map_;
  std::vector<bool> taken_;
};

}  // namespace

std::vector<EdgeCurve> TraceEdges(const cv::Mat& image, std::size_t shortest) {
  const EdgeMap map = FindPlaces(image);
  Tracer tracer(map);
  std::vector<EdgeCurve> curves;
  for (std::size_t pixel = 0; pixel < map.place.size(); ++pixel) {
    if (!tracer.IsFree(pixel)) continue;
    EdgeCurve curve = tracer.Trace(pixel);
    if (curve.size() >= shortest) curves.push_back(std::move(curve));
  }
  return curves;
}

}  // namespace mlic
