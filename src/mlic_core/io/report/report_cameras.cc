#include "mlic_core/io/report/report_cameras.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "mlic_core/io/pictures/track_picture.h"
#include "mlic_core/io/report/embedded_image.h"
#include "mlic_core/io/report/report_figures.h"
#include "mlic_core/io/result/export_frames.h"
#include "mlic_core/io/text_file.h"

namespace mlic {
namespace {

// Constants of this file, from: structural, how the report looks.

constexpr double kFigureWidth = 340.0;   // of a figure, in its own units
constexpr int kFewestObservations = 10;  // of a cell whose mean error says something
constexpr int kPictureWidth = 800;       // px
constexpr int kPictureQuality = 80;      // of JPEG

// 1, 2 or 5 times a power of ten: nine of ten arrows then stay within their cells.
double Magnification(const ResidualField& field, double pixels_of_cell) {
  std::vector<float> lengths;
  for (std::size_t i = 0; i < field.mean.size(); ++i) {
    if (field.counts[i] >= kFewestObservations) lengths.push_back(field.mean[i].norm());
  }
  if (lengths.empty()) return 1.0;
  const auto long_one = lengths.begin() + lengths.size() * 9 / 10;
  std::nth_element(lengths.begin(), long_one, lengths.end());
  const double largest = pixels_of_cell / std::max(1e-3f, *long_one);
  const double power = std::pow(10.0, std::floor(std::log10(std::max(1.0, largest))));
  for (const double factor : {5.0, 2.0}) {
    if (factor * power <= largest) return factor * power;
  }
  return power;
}

std::string Arrow(double x, double y, const Eigen::Vector2d& arrow, const std::string& color) {
  const Eigen::Vector2d tip = Eigen::Vector2d(x, y) + arrow;
  return "<line x1=\"" + SvgNumber(x) + "\" y1=\"" + SvgNumber(y) + "\" x2=\"" + SvgNumber(tip.x()) +
         "\" y2=\"" + SvgNumber(tip.y()) + "\" stroke=\"" + color + "\" stroke-width=\"1.4\"/><circle cx=\"" +
         SvgNumber(x) + "\" cy=\"" + SvgNumber(y) + "\" r=\"1.2\" fill=\"" + color + "\"/>";
}

std::string JpegFigure(const CameraView& view) {
  cv::Mat picture = DrawTracks(view.images->Load(view.image), view);
  if (picture.cols > kPictureWidth) {
    cv::resize(picture, picture, {kPictureWidth, picture.rows * kPictureWidth / picture.cols}, 0.0, 0.0,
               cv::INTER_AREA);
  }
  return "<img class=\"enlarge\" width=\"" + std::to_string(picture.cols) + "\" height=\"" +
         std::to_string(picture.rows) + "\" alt=\"tracks of " + EscapeXml(view.camera) + "\" src=\"" +
         EmbedJpeg(picture, kPictureQuality) + "\">\n";
}

}  // namespace

std::string ResidualFieldFigure(const ResidualSummary& residual, int width, int height,
                                const std::string& color) {
  const ResidualField& field = residual.over_image;
  const int most = field.counts.empty() ? 0 : *std::max_element(field.counts.begin(), field.counts.end());
  if (most == 0) return "<p class=\"none\">no residuals over the image</p>";
  const double scale = kFigureWidth / width, figure_height = scale * height;
  const double cell = scale * std::max(width, height) / std::max(field.columns, field.rows);
  const double factor = Magnification(field, cell / scale);
  std::string svg = "<svg viewBox=\"0 0 " + SvgNumber(kFigureWidth) + " " + SvgNumber(figure_height) +
                    "\" role=\"img\" aria-label=\"residuals of " + EscapeXml(residual.sensor) +
                    " over the image\">";
  std::string arrows;
  for (int row = 0; row < field.rows; ++row) {
    for (int column = 0; column < field.columns; ++column) {
      const std::size_t i = static_cast<std::size_t>(row) * field.columns + column;
      const double x = column * cell, y = row * cell;
      svg += "<rect x=\"" + SvgNumber(x) + "\" y=\"" + SvgNumber(y) + "\" width=\"" + SvgNumber(cell) +
             "\" height=\"" + SvgNumber(std::max(0.0, std::min(cell, figure_height - y))) +
             "\" fill=\"#2f6fb5\" fill-opacity=\"" + FixedNumber(0.3 * field.counts[i] / most, 3) + "\"/>";
      if (field.counts[i] < kFewestObservations) continue;
      arrows += Arrow(x + 0.5 * cell, y + 0.5 * cell, scale * factor * field.mean[i].cast<double>(), color);
    }
  }
  const long observations = std::accumulate(field.counts.begin(), field.counts.end(), 0L);
  return svg + arrows + "<rect width=\"" + SvgNumber(kFigureWidth) + "\" height=\"" +
         SvgNumber(figure_height) + "\" fill=\"none\" stroke=\"#9aa7b4\"/></svg>\n<p class=\"note\">" +
         std::to_string(observations) + " observations, rms " + FixedNumber(residual.rms, 3) +
         " px of each coordinate; arrows: mean errors &times; " + std::to_string(static_cast<int>(factor)) +
         "</p>\n";
}

std::string CameraResiduals(const CalibrationResult& result) {
  std::string html;
  for (std::size_t i = 0; i < result.sensors.size(); ++i) {
    const SensorResult& sensor = result.sensors[i];
    if (!sensor.intrinsics) continue;
    std::string card;
    for (const ResidualSummary& residual : result.residuals) {
      if (residual.sensor != sensor.name) continue;
      card +=
          ResidualFieldFigure(residual, sensor.intrinsics->width, sensor.intrinsics->height, SensorColor(i));
    }
    for (const CameraView& view : result.views) {
      if (view.camera == sensor.name) card += JpegFigure(view);
    }
    if (card.empty()) continue;
    if (sensor.held_out) {
      card += "<p class=\"note\">" + std::to_string(sensor.held_out->count) +
              " held-out matches with the LiDAR map: off by " + FixedNumber(sensor.held_out->median, 2) +
              " px in the median, " + FixedNumber(sensor.held_out->rms, 2) + " px rms</p>\n";
    }
    html += "<div class=\"card\"><h3><i style=\"background:" + SensorColor(i) + "\"></i>" +
            EscapeXml(sensor.name) + "</h3>\n" + card + "</div>\n";
  }
  if (html.empty()) return "";
  return "<div class=\"grid\">\n" + html +
         "</div>\n<p class=\"note\">Reprojection errors over the image: arrows that turn or stretch in a "
         "pattern show what the "
         "model of the lens does not follow. The darker a cell, the more observations. On the photo: a ring "
         "where a <dfn>landmark</dfn>, a plane or point of the world, was observed, its track through other "
         "images in "
         "blue, the error in red. Press the photo to enlarge it.</p>\n";
}

}  // namespace mlic
