#include "mlic_core/io/report/report_next_step.h"

#include <algorithm>

#include "mlic_core/io/result/export_frames.h"
#include "mlic_core/io/text_file.h"

namespace mlic {
namespace {

using Quantity = UnobservableDirection::Quantity;

bool HasUnobservable(const CalibrationResult& result, Quantity quantity) {
  return std::any_of(result.sensors.begin(), result.sensors.end(), [&](const SensorResult& sensor) {
    return std::any_of(
        sensor.unobservable.begin(), sensor.unobservable.end(),
        [&](const UnobservableDirection& direction) { return direction.quantity == quantity; });
  });
}

std::string PathIn(const std::filesystem::path& place, const std::string& file) {
  return ShellQuoted((std::filesystem::absolute(place) / file).lexically_normal());
}

// A command with a button that copies it (report.js).
std::string Command(const std::string& purpose, const std::string& command) {
  return "<li>" + purpose + "<pre class=\"copy\"><code>" + EscapeXml(command) + "</code></pre></li>\n";
}

std::string Commands(const CalibrationResult& result, const std::filesystem::path& place) {
  const std::string calibration = PathIn(place, "calibration.yaml");
  const std::string frame = FramesOf(result).root;
  std::string html = "<ol class=\"steps\">\n";
  html += Command("Publish where the sensors are, about <code>" + EscapeXml(frame) + "</code>:",
                  UseCommand(place));
  html += Command(
      "Or put them into the robot's own model, in its xacro file (where the model has these frames already, "
      "<code>export --format urdf --urdf</code> writes the numbers into it):",
      "<xacro:include filename=\"" +
          (std::filesystem::absolute(place) / "sensors_macro.xacro").lexically_normal().string() +
          "\"/>\n<xacro:mlic_sensors parent=\"" + frame + "\"/>");
  html +=
      Command("As a URDF of its own:", "xacro " + PathIn(place, "sensors.urdf.xacro") + " > sensors.urdf");
  html += Command(
      "Calibrate a second recording and compare: the two should differ by no more than their "
      "sigmas say:",
      "rosrun mlic compare " + calibration + " SECOND/calibration.yaml");
  if (result.root.empty()) {
    html += Command("Later, from 20 s of driving, ask whether it is still right:",
                    "rosrun mlic verify --calibration " + calibration + " --bag SHORT.bag");
  }
  return html + "</ol>\n";
}

}  // namespace

std::vector<std::string> Advice(const CalibrationResult& result) {
  std::vector<std::string> advice;
  for (const QualityCheck& check : result.checks) {
    if (check.Passed() || !check.refuses || result.Trusted()) continue;
    advice.push_back(check.name + (check.sensor.empty() ? "" : " of " + check.sensor) + ": " + check.remedy);
  }
  if (!result.Usable() || !result.root.empty()) {
    advice.push_back(
        "Record again with turns: a figure of eight in a vehicle, or turns about all three axes by hand, "
        "among walls and poles, for about a minute.");
    advice.push_back(
        "Or give T_imu_sensor with sigma in the rig file: it decides the directions that the drive does not "
        "determine.");
  }
  if (result.Usable() && HasUnobservable(result, Quantity::kTranslation)) {
    advice.push_back(
        "Unobservable translations: measure them by ruler or drawing and give them in the rig file with "
        "their sigma, or drive over kerbs and ramps so that the vehicle also rolls and pitches.");
  }
  if (HasUnobservable(result, Quantity::kRotation)) {
    advice.push_back("Unobservable rotations: turn about more than one axis, in both directions.");
  }
  if (HasUnobservable(result, Quantity::kTimeOffset)) {
    advice.push_back("Unobservable time offsets: change the rate of turning quickly, several times.");
  }
  for (const ResidualSummary& residual : result.residuals) {
    if (residual.inlier_share < 0.8) {
      advice.push_back(
          residual.sensor + ": only " + FixedNumber(100.0 * residual.inlier_share, 0) +
          " percent of its residuals are inliers; look for moving objects, its own vehicle in view, or a "
          "wrong point time.");
    }
  }
  return advice;
}

std::string UseCommand(const std::filesystem::path& place) {
  return "roslaunch " + PathIn(place, "static_transforms.launch");
}

std::string NextStep(const CalibrationResult& result, const std::filesystem::path& place) {
  std::string html = result.Usable() ? Commands(result, place) : "";
  const std::vector<std::string> advice = Advice(result);
  if (advice.empty()) return html;
  html += result.Usable() ? "<p>What would make it better:</p>\n<ul>\n" : "<ul>\n";
  for (const std::string& line : advice) html += "<li>" + EscapeXml(line) + "</li>\n";
  return html + "</ul>\n";
}

}  // namespace mlic
