#include "mlic_core/io/pictures/projection_picture.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

#include "mlic_core/common/order_statistics.h"
#include "mlic_core/io/text_file.h"

namespace mlic {
namespace {

// Constants of this file, from: structural, how a picture looks.

constexpr int kPanelWidth = 960;          // px, at most
constexpr double kPhotoBrightness = 0.6;  // what is left of it under points
constexpr int kFractionBits = 4;          // OpenCV draws at fractions of a pixel in fixed point
constexpr double kArrowShare = 1.0 / 40;  // of the panel's width: a long arrow
const cv::Scalar kRing(120, 255, 160), kArrow(60, 60, 255), kUnseen(60, 20, 0);

cv::Mat InColour(const cv::Mat& photo) {
  cv::Mat out = photo;
  if (photo.channels() == 1) cv::cvtColor(photo, out, cv::COLOR_GRAY2BGR);
  return out;
}

cv::Mat Shrunk(const cv::Mat& picture, int interpolation) {
  if (picture.cols <= kPanelWidth) return picture.clone();
  cv::Mat out;
  const int height = std::max(1, picture.rows * kPanelWidth / picture.cols);
  cv::resize(picture, out, {kPanelWidth, height}, 0.0, 0.0, interpolation);
  return out;
}

// A pixel of the photo in the panel, fixed point; a pixel's centre is a whole number in both.
cv::Point InPanel(const Eigen::Vector2f& pixel, double scale) {
  const auto to = [&](float x) {
    return static_cast<int>(std::lround(((x + 0.5) * scale - 0.5) * (1 << kFractionBits)));
  };
  return {to(pixel.x()), to(pixel.y())};
}

void Label(const std::string& text, cv::Mat* panel) {
  const double size = std::clamp(panel->cols / 1600.0, 0.4, 0.8);
  int below = 0;
  const cv::Size box = cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, size, 1, &below);
  const cv::Rect back(0, 0, box.width + 12, box.height + below + 10);
  cv::rectangle(*panel, back & cv::Rect(0, 0, panel->cols, panel->rows), cv::Scalar(20, 20, 20), cv::FILLED);
  cv::putText(*panel, text, {6, box.height + 5}, cv::FONT_HERSHEY_SIMPLEX, size, cv::Scalar(240, 240, 240), 1,
              cv::LINE_AA);
}

// Colours from 0 (blue) to 1 (red).
std::vector<cv::Scalar> Palette() {
  cv::Mat steps(1, 256, CV_8UC1), colours;
  for (int i = 0; i < 256; ++i) steps.at<unsigned char>(0, i) = static_cast<unsigned char>(i);
  cv::applyColorMap(steps, colours, cv::COLORMAP_JET);
  std::vector<cv::Scalar> palette;
  for (int i = 0; i < 256; ++i) palette.emplace_back(colours.at<cv::Vec3b>(0, i));
  return palette;
}

// Far points first, so that near ones stay visible. share: colour of each, 0 to 1.
cv::Mat DrawPoints(const cv::Mat& photo, const std::vector<ProjectedPoint>& points,
                   const std::vector<float>& share) {
  static const std::vector<cv::Scalar> kPalette = Palette();
  cv::Mat panel = Shrunk(photo, cv::INTER_AREA);
  panel.convertTo(panel, CV_8UC3, kPhotoBrightness);
  const double scale = static_cast<double>(panel.cols) / photo.cols;
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return points[a].depth > points[b].depth; });
  const int radius = static_cast<int>((panel.cols > 500 ? 1.3 : 0.8) * (1 << kFractionBits));
  for (const std::size_t i : order) {
    const auto step = static_cast<std::size_t>(std::lround(255.0f * std::clamp(share[i], 0.0f, 1.0f)));
    cv::circle(panel, InPanel(points[i].pixel, scale), radius, kPalette[step], cv::FILLED, cv::LINE_AA,
               kFractionBits);
  }
  return panel;
}

DepthRange RangeOf(const std::vector<ProjectedPoint>& points) {
  std::vector<float> depths;
  for (const ProjectedPoint& point : points) depths.push_back(point.depth);
  const float near = std::max(0.3f, Quantile(depths, 0.02));
  return {near, std::max(1.01f * near, Quantile(depths, 0.98))};
}

cv::Mat DrawInRange(const cv::Mat& photo, const std::vector<ProjectedPoint>& points,
                    const DepthRange& range) {
  const auto [near, far] = range;
  std::vector<float> share;
  for (const ProjectedPoint& point : points) {
    share.push_back(1.0f - std::log(std::max(point.depth, near) / near) / std::log(far / near));
  }
  return DrawPoints(photo, points, share);
}

cv::Mat DrawWithLegend(const cv::Mat& photo, const std::vector<ProjectedPoint>& points,
                       const std::string& when) {
  const DepthRange range = RangeOf(points);
  cv::Mat panel = DrawInRange(photo, points, range);
  Label("LiDAR by depth " + when + ", " + FixedNumber(range.near, 1) + " m (red) to " +
            FixedNumber(range.far, 0) + " m",
        &panel);
  return panel;
}

cv::Mat DrawByIntensity(const cv::Mat& photo, const std::vector<ProjectedPoint>& points,
                        const std::string& when) {
  std::vector<float> intensities, share;
  for (const ProjectedPoint& point : points) intensities.push_back(point.intensity);
  const float low = Quantile(intensities, 0.05), high = Quantile(intensities, 0.97);
  for (const float intensity : intensities) share.push_back((intensity - low) / std::max(1e-6f, high - low));
  cv::Mat panel = DrawPoints(photo, points, share);
  Label("LiDAR by intensity " + when + ", low blue, high red", &panel);
  return panel;
}

cv::Mat DrawMatches(const cv::Mat& photo, const CameraProjection& projection) {
  cv::Mat panel = Shrunk(photo, cv::INTER_AREA);
  panel.convertTo(panel, CV_8UC3, 0.8);
  const double scale = static_cast<double>(panel.cols) / photo.cols;
  std::vector<float> lengths;
  double squares = 0.0;
  for (const MatchProjection& observation : projection.matches) {
    lengths.push_back((observation.after - observation.observed).norm());
    squares += (observation.after - observation.observed).squaredNorm();
  }
  const double wanted = kArrowShare * panel.cols / scale / std::max(1e-3f, Quantile(lengths, 0.9));
  float factor = 1.0f;
  for (const float next : {2.0f, 5.0f, 10.0f, 20.0f, 50.0f, 100.0f}) {
    if (next <= wanted) factor = next;
  }
  for (const MatchProjection& observation : projection.matches) {
    const Eigen::Vector2f tip = observation.observed + factor * (observation.after - observation.observed);
    cv::circle(panel, InPanel(observation.observed, scale), 3 << kFractionBits, kRing, 1, cv::LINE_AA,
               kFractionBits);
    cv::line(panel, InPanel(observation.observed, scale), InPanel(tip, scale), kArrow, 1, cv::LINE_AA,
             kFractionBits);
  }
  std::string text = projection.camera + ": " + std::to_string(projection.matches.size()) + " matches";
  if (!lengths.empty()) {
    const double rms = std::sqrt(0.5 * squares / static_cast<double>(lengths.size()));
    text += ", rms " + FixedNumber(rms, 2) + " px, errors x" + FixedNumber(factor, 0);
  }
  Label(text, &panel);
  return panel;
}

cv::Mat DrawRendering(const cv::Mat& rendering, const cv::Size& size) {
  cv::Mat panel(rendering.size(), CV_8UC3, kUnseen);
  std::vector<float> values;
  for (int v = 0; v < rendering.rows; ++v) {
    for (int u = 0; u < rendering.cols; ++u) {
      const float value = rendering.at<float>(v, u);
      if (std::isfinite(value)) values.push_back(value);
    }
  }
  const float low = Quantile(values, 0.01), high = std::max(low + 1e-6f, Quantile(values, 0.99));
  for (int v = 0; v < rendering.rows; ++v) {
    for (int u = 0; u < rendering.cols; ++u) {
      const float value = rendering.at<float>(v, u);
      if (!std::isfinite(value)) continue;
      const auto gray =
          static_cast<unsigned char>(255.0f * std::clamp((value - low) / (high - low), 0.0f, 1.0f));
      panel.at<cv::Vec3b>(v, u) = {gray, gray, gray};
    }
  }
  cv::resize(panel, panel, size, 0.0, 0.0, panel.cols > size.width ? cv::INTER_AREA : cv::INTER_NEAREST);
  Label("the map, rendered after", &panel);
  return panel;
}

}  // namespace

cv::Mat DrawByDepth(const cv::Mat& photo, const std::vector<ProjectedPoint>& points,
                    const std::string& when) {
  if (points.empty()) return DrawPoints(InColour(photo), {}, {});
  return DrawWithLegend(InColour(photo), points, when);
}

cv::Mat DrawProjection(const cv::Mat& photo, const CameraProjection& projection) {
  const cv::Mat colour = InColour(photo);
  if (!projection.found) {
    const cv::Mat depth =
        DrawWithLegend(colour, projection.guess, "at the guess (" + projection.camera + " was not found)");
    cv::Mat picture;
    cv::hconcat(depth, DrawByIntensity(colour, projection.guess, "at the guess"), picture);
    return picture;
  }
  const cv::Mat matches = DrawMatches(colour, projection);
  const cv::Mat panels[6] = {matches,
                             DrawRendering(projection.rendering, matches.size()),
                             DrawWithLegend(colour, projection.before, "before"),
                             DrawWithLegend(colour, projection.after, "after"),
                             DrawByIntensity(colour, projection.before, "before"),
                             DrawByIntensity(colour, projection.after, "after")};
  cv::Mat picture(3 * matches.rows, 2 * matches.cols, CV_8UC3);
  for (int i = 0; i < 6; ++i) {
    const cv::Rect place(i % 2 * matches.cols, i / 2 * matches.rows, matches.cols, matches.rows);
    panels[i].copyTo(picture(place));
  }
  return picture;
}

OverlayPair DrawOverlays(const cv::Mat& photo, const CameraProjection& projection) {
  const cv::Mat colour = InColour(photo);
  const DepthRange range = RangeOf(projection.found ? projection.after : projection.guess);
  return {DrawInRange(colour, projection.guess.empty() ? projection.before : projection.guess, range),
          DrawInRange(colour, projection.after, range), range};
}

void WriteProjectionPictures(const std::filesystem::path& directory,
                             const std::vector<CameraProjection>& projections) {
  for (const CameraProjection& projection : projections) {
    std::vector<unsigned char> png;
    cv::imencode(".png", DrawProjection(projection.images->Load(projection.image), projection), png);
    WriteFileAtomically(directory / (projection.camera + "_projection.png"),
                        std::string(png.begin(), png.end()));
  }
}

}  // namespace mlic
