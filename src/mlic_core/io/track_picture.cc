#include "mlic_core/io/track_picture.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

#include "mlic_core/io/text_file.h"

namespace mlic {
namespace {

// Blue, green, red.
const cv::Scalar kTrackColour(255, 170, 60), kRingColour(120, 255, 160), kArrowColour(60, 60, 255);
constexpr double kPhotoBrightness = 0.7;  // what is left of the photo's, for the lines to stand out
constexpr int kFractionBits = 4;          // OpenCV draws at fractions of a pixel in fixed point

cv::Point Fixed(const Eigen::Vector2f& pixel) {
  constexpr float kScale = 1 << kFractionBits;
  return {static_cast<int>(std::lround(kScale * pixel.x())),
          static_cast<int>(std::lround(kScale * pixel.y()))};
}

void DrawLine(const Eigen::Vector2f& a, const Eigen::Vector2f& b, const cv::Scalar& colour, int thickness,
              cv::Mat* picture) {
  cv::line(*picture, Fixed(a), Fixed(b), colour, thickness, cv::LINE_AA, kFractionBits);
}

void DrawArrow(const Eigen::Vector2f& from, const Eigen::Vector2f& arrow, cv::Mat* picture) {
  const Eigen::Vector2f tip = from + arrow;
  DrawLine(from, tip, kArrowColour, 1, picture);
  const float head = std::min(4.0f, 0.4f * arrow.norm());
  if (head < 1.0f) return;
  const Eigen::Vector2f along = head * arrow.normalized(), across(-along.y(), along.x());
  DrawLine(tip, tip - along + 0.6f * across, kArrowColour, 1, picture);
  DrawLine(tip, tip - along - 0.6f * across, kArrowColour, 1, picture);
}

double RootMeanSquare(const CameraView& view) {
  double squares = 0.0;
  for (const LandmarkSight& sight : view.sights) squares += (sight.projected - sight.observed).squaredNorm();
  return view.sights.empty() ? 0.0 : std::sqrt(squares / static_cast<double>(view.sights.size()));
}

void DrawLegend(const std::string& text, cv::Mat* picture) {
  const double scale = std::clamp(picture->cols / 1600.0, 0.4, 1.2);
  int baseline = 0;
  const cv::Size size = cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, scale, 1, &baseline);
  const cv::Rect box(0, 0, std::min(picture->cols, size.width + 16), size.height + baseline + 12);
  cv::rectangle(*picture, box & cv::Rect(0, 0, picture->cols, picture->rows), cv::Scalar(20, 20, 20),
                cv::FILLED);
  cv::putText(*picture, text, {8, size.height + 6}, cv::FONT_HERSHEY_SIMPLEX, scale,
              cv::Scalar(240, 240, 240), 1, cv::LINE_AA);
}

}  // namespace

int ArrowMagnification(const CameraView& view, int image_width) {
  if (view.sights.empty()) return 1;
  std::vector<float> lengths;
  for (const LandmarkSight& sight : view.sights) lengths.push_back((sight.projected - sight.observed).norm());
  const auto long_one = lengths.begin() + lengths.size() * 9 / 10;
  std::nth_element(lengths.begin(), long_one, lengths.end());
  int factor = 1;
  for (const int next : {2, 5, 10, 20, 50, 100, 200, 500}) {
    if (next * *long_one <= image_width / 30.0f) factor = next;
  }
  return factor;
}

cv::Mat DrawTracks(const cv::Mat& photo, const CameraView& view) {
  cv::Mat picture;
  if (photo.channels() == 1) {
    cv::cvtColor(photo, picture, cv::COLOR_GRAY2BGR);
  } else {
    picture = photo.clone();
  }
  picture.convertTo(picture, CV_8UC3, kPhotoBrightness);
  const int factor = ArrowMagnification(view, photo.cols);
  for (const LandmarkSight& sight : view.sights) {
    for (std::size_t k = 1; k < sight.track.size(); ++k) {
      DrawLine(sight.track[k - 1], sight.track[k], kTrackColour, 1, &picture);
    }
  }
  for (const LandmarkSight& sight : view.sights) {
    cv::circle(picture, Fixed(sight.observed), 2 << kFractionBits, kRingColour, 1, cv::LINE_AA,
               kFractionBits);
    DrawArrow(sight.observed, static_cast<float>(factor) * (sight.projected - sight.observed), &picture);
  }
  DrawLegend(view.camera + ": " + std::to_string(view.sights.size()) + " landmarks, errors (red) x" +
                 std::to_string(factor) + ", rms " + FixedNumber(RootMeanSquare(view), 2) +
                 " px; blue: tracks",
             &picture);
  return picture;
}

void WriteTrackPictures(const std::filesystem::path& directory, const std::vector<CameraView>& views) {
  for (const CameraView& view : views) {
    std::vector<unsigned char> png;
    cv::imencode(".png", DrawTracks(view.images->Load(view.image), view), png);
    WriteFileAtomically(directory / (view.camera + "_tracks.png"), std::string(png.begin(), png.end()));
  }
}

}  // namespace mlic
