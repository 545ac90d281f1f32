#include "mlic_core/io/pictures/track_picture.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

#include "mlic_core/io/text_file.h"

namespace mlic {
namespace {

// Constants of this file, from: structural, how a picture looks.

// Blue, green, red.
const cv::Scalar kTrackColour(255, 170, 60), kRingColour(120, 255, 160), kArrowColour(60, 60, 255);
constexpr double kBehindTracks = 0.7;  // what is left of the photo's, for the lines to stand out
constexpr double kTrackOpacity = 0.55;
constexpr int kTrackFractionBits = 4;  // OpenCV draws at fractions of a pixel in fixed point

// Small photos are enlarged until lines and text have room.
constexpr int kLeastWidth = 800;  // px
// Large ones are looked at at half their size, and smaller.
constexpr int kWidthOfThinLines = 640;  // px, of the picture for each px of a line's width

int Enlargement(int image_width) { return (kLeastWidth + image_width - 1) / image_width; }

// Draws at pixels of the photo into its enlarged copy.
class Canvas {
 public:
  explicit Canvas(const cv::Mat& photo) : scale_(Enlargement(photo.cols)) {
    if (photo.channels() == 1) {
      cv::cvtColor(photo, picture_, cv::COLOR_GRAY2BGR);
    } else {
      picture_ = photo.clone();
    }
    picture_.convertTo(picture_, CV_8UC3, kBehindTracks);
    if (scale_ > 1) cv::resize(picture_, picture_, {}, scale_, scale_, cv::INTER_LINEAR);
    thickness_ = std::max(1, picture_.cols / kWidthOfThinLines);
  }
  void Line(const Eigen::Vector2f& a, const Eigen::Vector2f& b, const cv::Scalar& colour) {
    cv::line(picture_, Fixed(a), Fixed(b), colour, thickness_, cv::LINE_AA, kTrackFractionBits);
  }
  void Ring(const Eigen::Vector2f& centre) {
    cv::circle(picture_, Fixed(centre), (2 + thickness_) << kTrackFractionBits, kRingColour, thickness_,
               cv::LINE_AA, kTrackFractionBits);
  }
  float Scale() const { return static_cast<float>(scale_); }
  cv::Mat& picture() { return picture_; }

 private:
  cv::Point Fixed(const Eigen::Vector2f& pixel) const {
    // A pixel's centre is a whole number in both pictures.
    const Eigen::Vector2f enlarged =
        static_cast<float>(scale_) * (pixel + Eigen::Vector2f(0.5f, 0.5f)) - Eigen::Vector2f(0.5f, 0.5f);
    constexpr float kFraction = 1 << kTrackFractionBits;
    return {static_cast<int>(std::lround(kFraction * enlarged.x())),
            static_cast<int>(std::lround(kFraction * enlarged.y()))};
  }
  int scale_;
  int thickness_ = 1;  // px
  cv::Mat picture_;
};

void DrawArrow(const Eigen::Vector2f& from, const Eigen::Vector2f& arrow, Canvas* canvas) {
  const Eigen::Vector2f tip = from + arrow;
  canvas->Line(from, tip, kArrowColour);
  const float head = std::min(5.0f / canvas->Scale(), 0.4f * arrow.norm());
  const Eigen::Vector2f along = head * arrow.normalized(), across(-along.y(), along.x());
  canvas->Line(tip, tip - along + 0.6f * across, kArrowColour);
  canvas->Line(tip, tip - along - 0.6f * across, kArrowColour);
}

// Of each coordinate.
double RootMeanSquare(const CameraView& view) {
  double squares = 0.0;
  for (const LandmarkProjection& observation : view.observations)
    squares += (observation.projected - observation.observed).squaredNorm();
  return view.observations.empty() ? 0.0
                                   : std::sqrt(0.5 * squares / static_cast<double>(view.observations.size()));
}

void DrawLegend(const std::vector<std::string>& lines, cv::Mat* picture) {
  const double scale = std::clamp(picture->cols / 2000.0, 0.45, 1.2);
  int below = 0, width = 0, height = 0;
  for (const std::string& line : lines) {
    const cv::Size size = cv::getTextSize(line, cv::FONT_HERSHEY_SIMPLEX, scale, 1, &below);
    width = std::max(width, size.width);
    height = std::max(height, size.height);
  }
  const int step = height + below + 4;
  const cv::Rect box(0, 0, width + 16, static_cast<int>(lines.size()) * step + 6);
  cv::rectangle(*picture, box & cv::Rect(0, 0, picture->cols, picture->rows), cv::Scalar(20, 20, 20),
                cv::FILLED);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    cv::putText(*picture, lines[i], {8, static_cast<int>(i + 1) * step - below + 1}, cv::FONT_HERSHEY_SIMPLEX,
                scale, cv::Scalar(240, 240, 240), 1, cv::LINE_AA);
  }
}

}  // namespace

int ArrowMagnification(const CameraView& view, int image_width) {
  if (view.observations.empty()) return 1;
  std::vector<float> lengths;
  for (const LandmarkProjection& observation : view.observations)
    lengths.push_back((observation.projected - observation.observed).norm());
  const auto long_one = lengths.begin() + lengths.size() * 9 / 10;
  std::nth_element(lengths.begin(), long_one, lengths.end());
  int factor = 1;
  for (const int next : {2, 5, 10, 20, 50, 100, 200, 500}) {
    if (next * *long_one <= image_width / 30.0f) factor = next;
  }
  return factor;
}

cv::Mat DrawTracks(const cv::Mat& photo, const CameraView& view) {
  Canvas canvas(photo);
  const int factor = ArrowMagnification(view, photo.cols);
  const cv::Mat without_tracks = canvas.picture().clone();
  for (const LandmarkProjection& observation : view.observations) {
    for (std::size_t k = 1; k < observation.track.size(); ++k) {
      canvas.Line(observation.track[k - 1], observation.track[k], kTrackColour);
    }
  }
  cv::addWeighted(canvas.picture(), kTrackOpacity, without_tracks, 1.0 - kTrackOpacity, 0.0,
                  canvas.picture());
  for (const LandmarkProjection& observation : view.observations) {
    canvas.Ring(observation.observed);
    DrawArrow(observation.observed,
              static_cast<float>(factor) * (observation.projected - observation.observed), &canvas);
  }
  DrawLegend({view.camera + ": " + std::to_string(view.observations.size()) + " landmarks, rms " +
                  FixedNumber(RootMeanSquare(view), 2) + " px",
              "red: errors x" + std::to_string(factor) + "   blue: tracks"},
             &canvas.picture());
  return canvas.picture();
}

void WriteTrackPictures(const std::filesystem::path& directory, const std::vector<CameraView>& views) {
  for (const CameraView& view : views) {
    std::vector<unsigned char> png;
    cv::imencode(".png", DrawTracks(view.images->Load(view.image), view), png);
    WriteFileAtomically(directory / (view.camera + "_tracks.png"), std::string(png.begin(), png.end()));
  }
}

}  // namespace mlic
