#include "mlic_core/io/report/report_course.h"

#include <algorithm>
#include <cmath>

#include "mlic_core/common/angles.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/geometry/symmetric_matrix.h"
#include "mlic_core/io/report/report_figures.h"
#include "mlic_core/io/result/export_frames.h"
#include "mlic_core/io/text_file.h"

namespace mlic {
namespace {

// Constants of this file, from: structural, how the report looks.

constexpr double kStep = 0.1;              // s, of the curves of the motion
constexpr std::size_t kMostPoints = 1000;  // of a curve
const char* const kAxisColours[] = {"#d62728", "#2ca02c",
                                    "#1f77ff"};  // x, y, z, as in the drawing of the rig

std::string Card(const std::string& title, const std::string& content) {
  return "<div class=\"card\"><h3>" + title + "</h3>\n" + content + "</div>\n";
}

std::string AxisLegend() {
  std::string html = "<p class=\"legend\">axes of the IMU: ";
  for (int k = 0; k < 3; ++k) {
    html += "<span><i style=\"background:" + std::string(kAxisColours[k]) + "\"></i>" + "xyz"[k] + "</span>";
  }
  return html + "</p>\n";
}

std::vector<Curve> AxisCurves() {
  return {{kAxisColours[0], {}}, {kAxisColours[1], {}}, {kAxisColours[2], {}}};
}

std::string NumberCell(const std::string& text, const char* label) {
  return "<td class=\"n\" data-label=\"" + std::string(label) + "\">" + text + "</td>";
}

// Turning and acceleration between poses a step apart, along the axes of the IMU in the middle.
struct MotionCurves {
  std::vector<Curve> turning = AxisCurves();       // deg/s
  std::vector<Curve> acceleration = AxisCurves();  // m/s^2, without gravity
  Eigen::Matrix3d turning_squares = Eigen::Matrix3d::Zero();
};

MotionCurves CurvesOf(const std::vector<StampedPose>& poses) {
  const double period =
      SecondsSince(poses.front().time, poses.back().time) / static_cast<double>(poses.size() - 1);
  const auto apart = static_cast<std::size_t>(std::max(1.0, std::round(kStep / period)));
  const std::size_t stride = std::max(apart, poses.size() / kMostPoints);
  MotionCurves curves;
  double count = 0.0;
  for (std::size_t i = apart; i + apart < poses.size(); i += stride) {
    const StampedPose &before = poses[i - apart], &at = poses[i], &after = poses[i + apart];
    const double half = 0.5 * SecondsSince(before.time, after.time);
    const double seconds = SecondsSince(poses.front().time, at.time);
    const Eigen::Vector3d turning =
        Log(Eigen::Quaterniond(before.pose.rotation.conjugate() * after.pose.rotation)) / (2.0 * half);
    const Eigen::Vector3d acceleration =
        at.pose.rotation.conjugate() *
        Eigen::Vector3d(after.pose.translation - 2.0 * at.pose.translation + before.pose.translation) /
        (half * half);
    for (std::size_t k = 0; k < 3; ++k) {
      const auto axis = static_cast<Eigen::Index>(k);
      curves.turning[k].points.emplace_back(seconds, kDegreesPerRadian * turning[axis]);
      curves.acceleration[k].points.emplace_back(seconds, acceleration[axis]);
    }
    curves.turning_squares += turning * turning.transpose();
    count += 1.0;
  }
  if (count > 0.0) curves.turning_squares /= count;
  return curves;
}

}  // namespace

std::string ChangeFromGuess(const RigDrawing& drawing) {
  std::string rows;
  for (const DrawnSensor& sensor : drawing.sensors) {
    if (!sensor.guess) continue;
    const Eigen::Vector3d moved = 1e3 * (sensor.T_root_sensor.translation - sensor.guess->translation);
    const double turned =
        Log(Eigen::Quaterniond(sensor.T_root_sensor.rotation * sensor.guess->rotation.conjugate())).norm();
    rows += "<tr><td><i style=\"background:" + sensor.color + "\"></i>" + EscapeXml(sensor.name) + "</td>" +
            NumberCell(FixedNumber(kDegreesPerRadian * turned, 3), "turned by, &deg;") +
            NumberCell(FixedNumber(moved.x(), 1), "x, mm") + NumberCell(FixedNumber(moved.y(), 1), "y, mm") +
            NumberCell(FixedNumber(moved.z(), 1), "z, mm") +
            NumberCell(FixedNumber(moved.norm(), 1), "in all, mm") + "</tr>\n";
  }
  if (rows.empty()) return "";
  return "<div class=\"wide\"><table class=\"stack\"><thead><tr><th>sensor</th><th>turned by, &deg;</th>"
         "<th>x, mm</th><th>y, mm</th><th>z, mm</th><th>in all, mm</th></tr></thead>\n<tbody>" +
         rows +
         "</tbody></table></div>\n<p class=\"note\">Result less the rig file's guess, along the axes of " +
         EscapeXml(drawing.root) +
         ". Is this the error that you expect of the guess? If not, one of the two is wrong.</p>\n";
}

std::string Convergence(const CalibrationResult& result) {
  if (result.rounds.empty()) return "";
  Plot plot{"change of the calibration by rounds", "round", {}, {1.0}, true};
  std::string stage, legend = "<p class=\"legend\">";
  double round = 0.0;
  for (const RoundSummary& summary : result.rounds) {
    if (plot.curves.empty() || summary.stage != stage) {
      stage = summary.stage;
      const std::string color = SensorColor(plot.curves.size());
      plot.curves.push_back({color, {}});
      legend += "<span><i style=\"background:" + color + "\"></i>" + EscapeXml(stage) + "</span>";
    }
    round += 1.0;
    // A damped solve without sigmas counts as very large; a round that moved nothing as very small.
    plot.curves.back().points.emplace_back(round, std::clamp(summary.change, 1e-4, 1e4));
  }
  return "<div class=\"grid\">" + Card("moved by, in sigmas", PlotFigure(plot)) + "</div>\n" + legend +
         "</p>\n<p class=\"note\">A <dfn>round</dfn> finds anew which points belong together, and solves. "
         "Shown is the largest change of a sensor; it must end below 1 (dashed), and starts anew where more "
         "data join.</p>\n";
}

std::string Motion(const CalibrationResult& result) {
  if (result.trajectories.empty() || result.trajectories[0].size() < 3) return "";
  const MotionCurves curves = CurvesOf(result.trajectories[0]);
  if (curves.turning[0].points.size() < 2) return "";
  const SymmetricEigen<3> principal(curves.turning_squares);
  std::string rms;
  for (int k = 2; k >= 0; --k) {
    rms += (k < 2 ? ", " : "") +
           FixedNumber(kDegreesPerRadian * std::sqrt(std::max(0.0, principal.eigenvalues()[k])), 1);
  }
  const std::string across = "time in the drive, s";
  return "<div class=\"grid\">" +
         Card("turning, &deg;/s", PlotFigure({"angular rates of the IMU", across, curves.turning, {}})) +
         Card("acceleration, m/s&sup2;",
              PlotFigure({"accelerations of the IMU", across, curves.acceleration, {}})) +
         "</div>\n" + AxisLegend() + "<p class=\"note\">Means over " + FixedNumber(2.0 * kStep, 1) +
         " s, without gravity. Turning about its principal axes, root mean square: " + rms +
         " &deg;/s. <dfn>Excitation</dfn> is what of this shows the calibration: turning about two axes or "
         "more "
         "shows all rotations and positions, about one axis not the position along it.</p>\n";
}

std::string BiasOverTime(const CalibrationResult& result) {
  std::string cards;
  for (const ResidualSummary& residual : result.residuals) {
    const std::size_t count = std::min(residual.bias_over_time.size(), residual.over_time_seconds.size());
    if (count < 2) continue;
    Plot plot{"bias of the " + residual.sensor + " over time", "time in the drive, s", AxisCurves(), {}};
    Curve above{"currentColor", {}, true}, below = above;
    for (std::size_t i = 0; i < count; ++i) {
      const double time = residual.over_time_seconds[i],
                   bound = 3.0 * residual.bias_sigma_over_time[i].maxCoeff();
      for (std::size_t k = 0; k < 3; ++k) {
        plot.curves[k].points.emplace_back(time, residual.bias_over_time[i][static_cast<Eigen::Index>(k)]);
      }
      above.points.emplace_back(time, bound);
      below.points.emplace_back(time, -bound);
    }
    plot.curves.push_back(above);
    plot.curves.push_back(below);
    cards += Card(EscapeXml(residual.sensor) + ", " + EscapeXml(residual.unit), PlotFigure(plot));
  }
  if (cards.empty()) return "";
  return "<div class=\"grid\">" + cards + "</div>\n" + AxisLegend() +
         "<p class=\"note\">By how much the samples of each sixtieth of the drive would have the bias beyond "
         "the one above; dashed: three sigmas of their noise. What leaves these bounds for long is a bias "
         "that "
         "wanders (followed in drives of 10 s and more), or motion that the trajectory does not "
         "follow.</p>\n";
}

std::string HowItWasMade(const CalibrationResult& result) {
  if (!result.run) return "";
  const RunRecord& run = *result.run;
  std::string html = "<pre class=\"copy\"><code>" + EscapeXml(run.command) + "</code></pre>\n<p>by MLIC " +
                     EscapeXml(run.version) +
                     ", of</p>\n<div class=\"wide\"><table class=\"stack\"><thead><tr>"
                     "<th>input</th><th>hash of its content</th></tr></thead>\n<tbody>";
  for (const RunInput& input : run.inputs) {
    html += "<tr><td>" + EscapeXml(input.path) + "</td><td><code>" + EscapeXml(input.hash) +
            "</code></td></tr>\n";
  }
  html += "</tbody></table></div>\n";
  if (run.options.empty()) return html;
  html += "<details><summary>options</summary>\n<div class=\"wide\"><table>";
  for (const auto& [name, value] : run.options) {
    html += "<tr><th>" + EscapeXml(name) + "</th><td>" + EscapeXml(value) + "</td></tr>\n";
  }
  return html +
         "</table></div></details>\n<p class=\"note\">The same build, inputs, options and number of "
         "threads give the same bytes again.</p>\n";
}

}  // namespace mlic
