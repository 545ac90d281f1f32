#include "mlic_core/io/report/report_rig.h"

#include <algorithm>
#include <cmath>

#include "mlic_core/io/report/report_figures.h"
#include "mlic_core/io/result/export_frames.h"
#include "mlic_core/io/text_file.h"

namespace mlic {
namespace {

// Constants of this file, from: structural, how the report looks.

constexpr double kSize = 520.0;      // of a view, in its own units
constexpr double kMargin = 90.0;     // for names and views of cameras
constexpr double kAxisShare = 0.12;  // of the extent: the length of a sensor's axes

// Onto two of the vehicle's axes.
struct Projection {
  Eigen::Vector3d across, down;  // root's frame, per metre
  Eigen::Vector2d middle;
  double scale = 1.0;

  Eigen::Vector2d At(const Eigen::Vector3d& p) const {
    return Eigen::Vector2d::Constant(0.5 * kSize) +
           scale * (Eigen::Vector2d(across.dot(p), down.dot(p)) - middle);
  }
};

// Around the sensors, their guesses and the root.
Projection Fit(const RigDrawing& drawing, const Eigen::Vector3d& across, const Eigen::Vector3d& down) {
  Projection projection{across, down, Eigen::Vector2d::Zero()};
  Eigen::Vector2d low = Eigen::Vector2d::Zero(), high = Eigen::Vector2d::Zero();
  const auto include = [&](const RigidTransform& pose) {
    const Eigen::Vector2d p(across.dot(pose.translation), down.dot(pose.translation));
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  };
  for (const DrawnSensor& sensor : drawing.sensors) {
    include(sensor.T_root_sensor);
    if (sensor.guess) include(*sensor.guess);
  }
  projection.middle = 0.5 * (low + high);
  projection.scale = (kSize - 2.0 * kMargin) / std::max((high - low).maxCoeff(), 0.5 * drawing.extent);
  return projection;
}

std::string Stroke(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const std::string& attributes) {
  return "<line x1=\"" + SvgNumber(a.x()) + "\" y1=\"" + SvgNumber(a.y()) + "\" x2=\"" + SvgNumber(b.x()) +
         "\" y2=\"" + SvgNumber(b.y()) + "\" " + attributes + "/>";
}

// Red, green, blue: x, y, z.
std::string Axes(const Projection& view, const RigidTransform& pose, double length, bool guess) {
  static const char* const kColours[] = {"#d62728", "#2ca02c", "#1f77ff"};
  std::string svg;
  for (int k = 0; k < 3; ++k) {
    svg +=
        Stroke(view.At(pose.translation), view.At(pose * Eigen::Vector3d(length * Eigen::Vector3d::Unit(k))),
               "stroke=\"" + std::string(kColours[k]) +
                   (guess ? "\" stroke-width=\"1\" stroke-dasharray=\"3 3\"" : "\" stroke-width=\"2.5\""));
  }
  return svg;
}

std::string Outline(const Projection& view, const DrawnSensor& sensor, double length) {
  if (sensor.outline.empty()) return "";
  std::string points;
  for (const Eigen::Vector3d& bearing : sensor.outline) {
    const Eigen::Vector2d p = view.At(sensor.T_root_sensor * Eigen::Vector3d(length * bearing));
    points += SvgNumber(p.x()) + "," + SvgNumber(p.y()) + " ";
  }
  std::string svg = "<polygon points=\"" + points + "\" fill=\"" + sensor.color +
                    "\" fill-opacity=\"0.12\" stroke=\"" + sensor.color + "\"/>";
  for (std::size_t i = 0; i < sensor.outline.size();
       i += std::max<std::size_t>(1, sensor.outline.size() / 4)) {
    svg += Stroke(view.At(sensor.T_root_sensor.translation),
                  view.At(sensor.T_root_sensor * Eigen::Vector3d(length * sensor.outline[i])),
                  "stroke=\"" + sensor.color + "\" stroke-opacity=\"0.6\"");
  }
  return svg;
}

std::string Name(const Eigen::Vector2d& at, const std::string& name, double* last_row) {
  // Names one below the other where sensors lie close together.
  double row = at.y() - 6.0;
  if (std::abs(row - *last_row) < 13.0) row = *last_row + 13.0;
  *last_row = row;
  return "<text class=\"name\" x=\"" + SvgNumber(at.x() + 7.0) + "\" y=\"" + SvgNumber(row) + "\">" +
         EscapeXml(name) + "</text>";
}

std::string ViewOf(const RigDrawing& drawing, const std::string& title, const Eigen::Vector3d& across,
                   const Eigen::Vector3d& down) {
  const Projection view = Fit(drawing, across, down);
  const double length = kAxisShare * drawing.extent;
  std::string svg = "<svg class=\"rig\" role=\"img\" aria-label=\"the rig " + title + "\" viewBox=\"0 0 " +
                    SvgNumber(kSize) + " " + SvgNumber(kSize) + "\"><text class=\"big\" x=\"12\" y=\"24\">" +
                    title + "</text>";
  svg += Axes(view, RigidTransform(), 1.3 * length, false);
  std::vector<std::pair<Eigen::Vector2d, std::string>> names{
      {view.At(Eigen::Vector3d::Zero()), drawing.root}};
  for (const DrawnSensor& sensor : drawing.sensors) {
    const Eigen::Vector2d at = view.At(sensor.T_root_sensor.translation);
    svg += Outline(view, sensor, 1.6 * length);
    if (sensor.guess) {
      svg += Axes(view, *sensor.guess, length, true);
      svg += Stroke(view.At(sensor.guess->translation), at, "stroke=\"" + sensor.color + "\"");
    }
    svg += Axes(view, sensor.T_root_sensor, length, false) + "<circle cx=\"" + SvgNumber(at.x()) +
           "\" cy=\"" + SvgNumber(at.y()) + "\" r=\"4\" fill=\"" + sensor.color + "\"/>";
    names.emplace_back(at, sensor.name);
  }
  std::sort(names.begin(), names.end(),
            [](const auto& a, const auto& b) { return a.first.y() < b.first.y(); });
  double last_row = -1e9;
  for (const auto& [at, name] : names) svg += Name(at, name, &last_row);
  const double metres = std::pow(10.0, std::floor(std::log10(0.5 * kSize / view.scale)));
  return svg + Stroke({16.0, kSize - 16.0}, {16.0 + metres * view.scale, kSize - 16.0}, "class=\"scale\"") +
         "<text class=\"name\" x=\"16\" y=\"" + SvgNumber(kSize - 22.0) + "\">" + ShortNumber(metres, 3) +
         " m</text></svg>\n";
}

}  // namespace

std::string RigFigure(const RigDrawing& drawing, bool turnable) {
  if (drawing.sensors.empty()) return "";
  const Eigen::Vector3d forward = drawing.R_view_root.row(0), left = drawing.R_view_root.row(1),
                        up = drawing.R_view_root.row(2);
  const bool guessed = std::any_of(drawing.sensors.begin(), drawing.sensors.end(),
                                   [](const DrawnSensor& sensor) { return sensor.guess.has_value(); });
  std::string html;
  if (turnable) {
    html += "<div id=\"rig-view\" hidden></div>\n";
  } else {
    html +=
        "<p class=\"note\">Still pictures: MLIC was built without three.js (Debian's libjs-three), which "
        "turns them.</p>\n";
  }
  html += "<div id=\"rig-still\" class=\"grid\">\n" + ViewOf(drawing, "from above", -left, -forward) +
          ViewOf(drawing, "from the left", -forward, -up) + "</div>\n";
  html += "<p class=\"note\">Is each sensor where it is bolted? Axes: x red, y green, z blue; of " +
          EscapeXml(drawing.root) + " the largest. Cameras with the outline of what they see.";
  if (guessed) html += " Thin or dashed: the guess of the rig file, joined to the result by a line.";
  return html + "</p>\n";
}

std::string FrameChoice(const RigDrawing& drawing) {
  if (drawing.sensors.empty()) return "";
  return "<div id=\"frame-choice\"><noscript>Needs a browser with JavaScript; <code>rosrun mlic export "
         "--parent FRAME</code> does the same.</noscript></div>\n";
}

}  // namespace mlic
