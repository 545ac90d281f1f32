#include "mlic_core/io/report/report_top_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>

#include "mlic_core/io/report/embedded_image.h"
#include "mlic_core/io/report/report_figures.h"
#include "mlic_core/io/result/export_frames.h"
#include "mlic_core/io/text_file.h"

namespace mlic {
namespace {

// Constants of this file, from: structural, how the report looks.

constexpr int kLongSide = 1000;  // pixels

struct View {
  Eigen::Vector2d low, high;  // metres in the map's x and y
  double scale = 1.0;         // pixels for each metre
  int width = 0, height = 0;

  double Column(double x) const { return (x - low.x()) * scale; }
  double Row(double y) const { return (high.y() - y) * scale; }
};

// Without the farthest half percent on each side: a few stray points must not shrink the rest.
void RobustRange(std::vector<float>* values, double* low, double* high) {
  if (values->empty()) return;
  const std::size_t cut = values->size() / 200;
  std::nth_element(values->begin(), values->begin() + cut, values->end());
  *low = std::min(*low, static_cast<double>((*values)[cut]));
  std::nth_element(values->begin(), values->end() - 1 - cut, values->end());
  *high = std::max(*high, static_cast<double>(*(values->end() - 1 - cut)));
}

View ChooseView(const CalibrationResult& result) {
  View view;
  view.low.setConstant(1e12);
  view.high.setConstant(-1e12);
  if (!result.trajectories.empty()) {
    for (const StampedPose& pose : result.trajectories[0]) {
      view.low = view.low.cwiseMin(pose.pose.translation.head<2>());
      view.high = view.high.cwiseMax(pose.pose.translation.head<2>());
    }
  }
  for (int axis = 0; axis < 2; ++axis) {
    std::vector<float> values;
    for (const MapPoint& point : result.map) values.push_back(point.position[axis]);
    RobustRange(&values, &view.low[axis], &view.high[axis]);
  }
  const double margin = 0.03 * (view.high - view.low).maxCoeff() + 0.5;
  view.low.array() -= margin;
  view.high.array() += margin;
  const Eigen::Vector2d size = view.high - view.low;
  view.scale = kLongSide / size.maxCoeff();
  view.width = std::max(1, static_cast<int>(std::ceil(size.x() * view.scale)));
  view.height = std::max(1, static_cast<int>(std::ceil(size.y() * view.scale)));
  return view;
}

std::array<std::uint8_t, 3> Shaded(const std::string& color, double strength) {
  std::array<std::uint8_t, 3> rgb{};
  for (std::size_t k = 0; k < 3; ++k) {
    const double channel = std::stoi(color.substr(1 + 2 * k, 2), nullptr, 16);
    rgb[k] = static_cast<std::uint8_t>(255.0 - strength * (255.0 - channel));
  }
  return rgb;
}

// BGRA, transparent where there is no point.
cv::Mat DrawPoints(const CalibrationResult& result, const View& view) {
  std::vector<int> last(static_cast<std::size_t>(view.width) * view.height, -1), counts(last.size(), 0);
  for (const MapPoint& point : result.map) {
    const int column = static_cast<int>(std::floor(view.Column(point.position.x())));
    const int row = static_cast<int>(std::floor(view.Row(point.position.y())));
    if (column < 0 || row < 0 || column >= view.width || row >= view.height) continue;
    const std::size_t pixel = static_cast<std::size_t>(row) * view.width + column;
    ++counts[pixel];
    last[pixel] = std::max(point.lidar, 0);
  }
  cv::Mat image(view.height, view.width, CV_8UC4, cv::Scalar(255, 255, 255, 0));
  for (int row = 0, i = 0; row < view.height; ++row) {
    for (int column = 0; column < view.width; ++column, ++i) {
      if (last[i] < 0) continue;
      const int shade = counts[i] >= 6 ? 2 : (counts[i] >= 2 ? 1 : 0);
      const auto rgb = Shaded(SensorColor(last[i]), 0.65 + 0.175 * shade);
      image.at<cv::Vec4b>(row, column) = cv::Vec4b(rgb[2], rgb[1], rgb[0], 255);
    }
  }
  return image;
}

std::string PathOf(const std::vector<StampedPose>& poses, const View& view) {
  std::string points;
  const std::size_t step = std::max<std::size_t>(1, poses.size() / 2000);
  for (std::size_t i = 0; i < poses.size(); i += step) {
    const Eigen::Vector3d& p = poses[i].pose.translation;
    points += FixedNumber(view.Column(p.x()), 1) + "," + FixedNumber(view.Row(p.y()), 1) + " ";
  }
  return points;
}

std::string Dot(const StampedPose& pose, const View& view, const std::string& color,
                const std::string& label) {
  const std::string x = FixedNumber(view.Column(pose.pose.translation.x()), 1);
  const std::string y = FixedNumber(view.Row(pose.pose.translation.y()), 1);
  return "<circle cx=\"" + x + "\" cy=\"" + y + "\" r=\"8\" fill=\"" + color +
         "\" stroke=\"#fff\" stroke-width=\"2\"><title>" + label + "</title></circle>";
}

std::string ScaleBar(const View& view) {
  const double rough = 160.0 / view.scale;
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  const double length = power * (rough >= 5.0 * power ? 5.0 : rough >= 2.0 * power ? 2.0 : 1.0);
  const std::string right = FixedNumber(20.0 + length * view.scale, 1);
  const std::string y = std::to_string(view.height - 18);
  return "<line x1=\"20\" y1=\"" + y + "\" x2=\"" + right + "\" y2=\"" + y +
         "\" stroke=\"#222\" stroke-width=\"4\"/><text x=\"20\" y=\"" + std::to_string(view.height - 28) +
         "\" class=\"big\">" + ShortNumber(length, 3) + " m</text>";
}

}  // namespace

std::string TopViewFigure(const CalibrationResult& result) {
  const bool has_path = !result.trajectories.empty() && !result.trajectories[0].empty();
  if (!has_path && result.map.empty()) return "";
  const View view = ChooseView(result);
  int largest = 0;
  for (const MapPoint& point : result.map) largest = std::max(largest, point.lidar);
  const std::size_t lidars = static_cast<std::size_t>(largest) + 1;
  const std::string size = std::to_string(view.width) + "\" height=\"" + std::to_string(view.height) + "\"";
  std::string html = "<svg class=\"map\" role=\"img\" aria-label=\"top view\" viewBox=\"0 0 " +
                     std::to_string(view.width) + " " + std::to_string(view.height) + "\">";
  if (!result.map.empty()) {
    html += "<image width=\"" + size + " href=\"" + EmbedPng(DrawPoints(result, view)) + "\"/>";
  }
  if (has_path) {
    const std::vector<StampedPose>& poses = result.trajectories[0];
    html += "<polyline points=\"" + PathOf(poses, view) + "\" class=\"path\"/>";
    html += Dot(poses.back(), view, "#c0392b", "end") + Dot(poses.front(), view, "#1e8449", "start");
  }
  html += ScaleBar(view) + "</svg>\n<p class=\"legend\">";
  for (std::size_t i = 0; i < result.sensors.size() && i < lidars && !result.map.empty(); ++i) {
    html += "<span><i style=\"background:" + SensorColor(i) + "\"></i>" + EscapeXml(result.sensors[i].name) +
            "</span>";
  }
  if (has_path) {
    html +=
        "<span><i style=\"background:#111\"></i>path of the IMU</span><span><i "
        "style=\"background:#1e8449\"></i>"
        "start</span><span><i style=\"background:#c0392b\"></i>end</span>";
  }
  return html +
         "</p>\n<p class=\"note\">The LiDARs' map, points by the LiDAR that saw them, in the frame map: z "
         "up, origin at the "
         "first pose of the IMU." +
         (result.trajectories.size() > 1
              ? " Of the first of " + std::to_string(result.trajectories.size()) + " drives."
              : std::string()) +
         "</p>\n";
}

}  // namespace mlic
