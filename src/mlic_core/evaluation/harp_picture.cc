#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "mlic_core/evaluation/harp.h"

namespace mlic {
namespace {

// Constants of this file, from: structural, how a picture looks.

// Blue, green, red.
const cv::Scalar kPlaceColour(120, 255, 160), kErrorColour(60, 60, 255), kTextColour(240, 240, 240);
const cv::Scalar kHarpBackground(30, 30, 30), kBarColour(255, 170, 60);
constexpr int kLeastWidth = 800;  // px, of the picture
constexpr double kMuted = 0.6;    // what is left of the photo's brightness
constexpr int kHistogramHeight = 220;
constexpr int kMargin = 30;
constexpr double kTextScale = 0.5;
constexpr double kDrawnShare = 0.02;  // of the photo's width, the largest distance as it is drawn

void PutText(const std::string& text, const cv::Point& place, cv::Mat* picture) {
  cv::putText(*picture, text, place, cv::FONT_HERSHEY_SIMPLEX, kTextScale, kTextColour, 1, cv::LINE_AA);
}

std::string InPixels(const char* format, double value) {
  char text[40];
  std::snprintf(text, sizeof(text), format, value);
  return text;
}

// 1, 2 or 5 times a power of ten.
int MagnificationOf(double largest, int width) {
  int factor = 1;
  for (const int next : {2, 5, 10, 20, 50, 100, 200, 500}) {
    if (next * largest <= kDrawnShare * width) factor = next;
  }
  return factor;
}

cv::Mat DrawHistogram(const HarpMeasurement& measurement, int width) {
  cv::Mat picture(kHistogramHeight, width, CV_8UC3, kHarpBackground);
  const HarpHistogram histogram = HistogramOf(measurement);
  const std::size_t most = *std::max_element(histogram.counts.begin(), histogram.counts.end());
  const int base = kHistogramHeight - kMargin, height = base - kMargin;
  const double step = static_cast<double>(width - 2 * kMargin) / static_cast<double>(histogram.counts.size());
  for (std::size_t i = 0; i < histogram.counts.size(); ++i) {
    const double share =
        static_cast<double>(histogram.counts[i]) / static_cast<double>(std::max<std::size_t>(1, most));
    const int left = kMargin + static_cast<int>(step * static_cast<double>(i));
    const int right = kMargin + static_cast<int>(step * static_cast<double>(i + 1)) - 2;
    cv::rectangle(picture, {left, base - static_cast<int>(share * height)}, {right, base}, kBarColour,
                  cv::FILLED);
  }
  cv::line(picture, {kMargin, base}, {width - kMargin, base}, kTextColour);
  PutText(InPixels("%.2f px", -histogram.limit), {kMargin, kHistogramHeight - 10}, &picture);
  PutText("0", {width / 2 - 4, kHistogramHeight - 10}, &picture);
  PutText(InPixels("%.2f px", histogram.limit), {width - kMargin - 70, kHistogramHeight - 10}, &picture);
  PutText("all photos: " + std::to_string(measurement.all.lines) + " edges, " +
              InPixels("%.3f px rms, ", measurement.all.rms) +
              InPixels("%.3f px at most", measurement.all.largest),
          {kMargin, 20}, &picture);
  return picture;
}

}  // namespace

cv::Mat DrawHarp(const cv::Mat& photo, const HarpPhoto& lines, const HarpMeasurement& measurement) {
  cv::Mat picture;
  if (photo.channels() == 1) {
    cv::cvtColor(photo, picture, cv::COLOR_GRAY2BGR);
  } else {
    picture = photo.clone();
  }
  picture.convertTo(picture, CV_8UC3, kMuted);
  const int scale = (kLeastWidth + photo.cols - 1) / photo.cols;
  if (scale > 1) cv::resize(picture, picture, {}, scale, scale, cv::INTER_LINEAR);
  const int factor = MagnificationOf(lines.errors.largest, photo.cols);
  // A pixel's centre is a whole number in both pictures.
  const auto at = [&](const Eigen::Vector2d& place) {
    return cv::Point(static_cast<int>(std::lround(scale * (place.x() + 0.5) - 0.5)),
                     static_cast<int>(std::lround(scale * (place.y() + 0.5) - 0.5)));
  };
  for (const HarpLine& line : lines.lines) {
    const Eigen::Vector2d along = (line.places.back() - line.places.front()).normalized();
    const Eigen::Vector2d across(-along.y(), along.x());
    for (std::size_t i = 0; i + 1 < line.places.size(); ++i) {
      cv::line(picture, at(line.places[i]), at(line.places[i + 1]), kPlaceColour, 1, cv::LINE_AA);
      cv::line(picture, at(line.places[i] + factor * line.distances[i] * across),
               at(line.places[i + 1] + factor * line.distances[i + 1] * across), kErrorColour, 1,
               cv::LINE_AA);
    }
  }
  cv::rectangle(picture, {0, 0}, {picture.cols, 26}, kHarpBackground, cv::FILLED);
  PutText(lines.name + ": " + std::to_string(lines.errors.lines) + " edges, " +
              InPixels("%.3f px rms, ", lines.errors.rms) +
              InPixels("%.3f px at most", lines.errors.largest) + "; red: off the straight line, x" +
              std::to_string(factor),
          {8, 18}, &picture);
  cv::vconcat(picture, DrawHistogram(measurement, picture.cols), picture);
  return picture;
}

}  // namespace mlic
