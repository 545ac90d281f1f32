#include "mlic_core/io/report/report_verdict.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "mlic_core/io/result/export_frames.h"
#include "mlic_core/io/result/result_names.h"
#include "mlic_core/io/text_file.h"

namespace mlic {
namespace {

constexpr double kDegreesPerRadian = 180.0 / M_PI;

bool HasUnobservable(const std::vector<UnobservableDirection>& directions,
                     UnobservableDirection::Quantity quantity) {
  return std::any_of(directions.begin(), directions.end(),
                     [&](const UnobservableDirection& direction) { return direction.quantity == quantity; });
}

bool HasUnobservable(const CalibrationResult& result, UnobservableDirection::Quantity quantity) {
  return std::any_of(result.sensors.begin(), result.sensors.end(), [&](const SensorResult& sensor) {
    return HasUnobservable(sensor.unobservable, quantity);
  });
}

// The largest of a pair's sigmas along the axes without what its unobservable directions have of them.
double Shown(const PairResult& pair, UnobservableDirection::Quantity quantity, const Eigen::Vector3d& sigma) {
  Eigen::Array3d variance = sigma.array().square();
  for (const UnobservableDirection& unshown : pair.unobservable) {
    if (unshown.quantity == quantity) variance -= (unshown.sigma * unshown.direction).array().square();
  }
  return std::sqrt(std::max(0.0, variance.maxCoeff()));
}

std::string Tile(const std::string& number, const std::string& meaning) {
  return "<div class=\"tile\"><b>" + number + "</b><span>" + meaning + "</span></div>";
}

// The largest sigmas among what the drive showed, in the units of people.
std::string Tiles(const CalibrationResult& result) {
  const LargestSigmas sigmas = FindLargestSigmas(result);
  std::string html =
      "<div class=\"tiles\">" + Tile(std::to_string(result.sensors.size()), "sensors calibrated");
  if (!result.root.empty()) html += Tile(std::to_string(result.pairs.size()), "pairs of sensors");
  if (!result.sensors.empty() || !result.root.empty()) {
    html +=
        Tile(FixedNumber(kDegreesPerRadian * sigmas.rotation, 4) + "&deg;", "largest &sigma; of a rotation");
    html += Tile(FixedNumber(1e3 * sigmas.translation, 1) + " mm",
                 "largest &sigma; of an observable translation");
    if (sigmas.time_offset > 0.0) {
      html += Tile(FixedNumber(1e3 * sigmas.time_offset, 3) + " ms", "largest &sigma; of a time offset");
    }
  }
  if (!result.trajectories.empty() && result.trajectories[0].size() > 1) {
    double length = 0.0, seconds = 0.0;
    for (const std::vector<StampedPose>& poses : result.trajectories) {
      for (std::size_t i = 1; i < poses.size(); ++i) {
        length += (poses[i].pose.translation - poses[i - 1].pose.translation).norm();
      }
      if (!poses.empty()) seconds += SecondsSince(poses.front().time, poses.back().time);
    }
    html += Tile(FixedNumber(length, 0) + " m", "driven in " + FixedNumber(seconds, 0) + " s");
  }
  if (result.peak_memory_megabytes > 0.0)
    html += Tile(FixedNumber(result.peak_memory_megabytes / 1024.0, 2) + " GB", "peak memory");
  return html + "</div>\n";
}

std::string List(const std::vector<std::string>& lines) {
  std::string html = "<ul>\n";
  for (const std::string& line : lines) html += "<li>" + EscapeXml(line) + "</li>\n";
  return html + "</ul>\n";
}

// Every check, those that failed first; shut until it is asked for where all passed.
std::string ChecksTable(const std::vector<QualityCheck>& checks) {
  if (checks.empty()) return "";
  std::string failed, passed;
  std::size_t failures = 0;
  for (const QualityCheck& check : checks) {
    const bool good = check.Passed();
    failures += good ? 0 : 1;
    (good ? passed : failed) +=
        "<tr><td>" + EscapeXml(check.name) + "</td><td>" + EscapeXml(check.sensor) + "</td><td class=\"n\">" +
        ShortNumber(check.value, 3) + "</td><td class=\"n\">" +
        (check.bound == QualityCheck::Bound::kMost ? "&le; " : "&ge; ") + ShortNumber(check.limit, 3) +
        "</td><td>" + EscapeXml(check.unit) + "</td><td>" + (good ? "passed" : "<b>failed</b>") +
        "</td><td>" + (good ? "" : EscapeXml(check.remedy)) + "</td></tr>\n";
  }
  return std::string("<details") + (failures > 0 ? " open" : "") + "><summary>" +
         std::to_string(checks.size() - failures) + " of " + std::to_string(checks.size()) +
         " checks passed</summary>\n<div "
         "class=\"wide\"><table><tr><th>check</th><th>sensor</th><th>value</th>"
         "<th>limit</th><th></th><th></th><th>what to do</th></tr>\n" +
         failed + passed + "</table></div></details>\n";
}

}  // namespace

std::string VerdictBlock(const CalibrationResult& result) {
  const bool unobservable =
      std::any_of(result.sensors.begin(), result.sensors.end(),
                  [](const SensorResult& sensor) { return !sensor.unobservable.empty(); });
  const std::string name = VerdictName(result.verdict);
  std::string title = name;
  title[0] = static_cast<char>(std::toupper(title[0]));
  std::string html = "<section class=\"verdict " + name + "\">\n<h1>" + title + "</h1>\n<p class=\"lead\">";
  if (!result.root.empty()) {
    html += "The pairs of sensors below can be used, and launch file and URDF, which are about " +
            EscapeXml(result.root) + ". Nothing ties them to the IMU:</p>\n" + List(result.reasons);
  } else if (result.verdict == Verdict::kPartial) {
    html += "The sensors below can be used. Others of the rig were rejected and are not given:</p>\n" +
            List(result.reasons);
  } else if (!result.Usable()) {
    html += "Do not use this calibration: the recording does not determine it, or a check failed.</p>\n" +
            List(result.reasons.empty() ? std::vector<std::string>{"no reason was given; see log.txt"}
                                        : result.reasons);
  } else if (unobservable) {
    html +=
        "The calibration can be used. Some directions, marked <b>unobservable</b> below, are not determined "
        "by "
        "this drive: there the given guess decides.</p>\n";
  } else {
    html += "The calibration can be used: the drive determines every direction of every sensor.</p>\n";
  }
  if (!result.warnings.empty()) html += "<p>Warnings:</p>\n" + List(result.warnings);
  return html + ChecksTable(result.checks) + Tiles(result) + "</section>\n";
}

LargestSigmas FindLargestSigmas(const CalibrationResult& result) {
  using Quantity = UnobservableDirection::Quantity;
  LargestSigmas largest;
  for (const PairResult& pair : result.pairs) {
    if (result.root.empty()) break;
    largest.rotation = std::max(largest.rotation, Shown(pair, Quantity::kRotation, pair.sigma.rotation));
    largest.translation =
        std::max(largest.translation, Shown(pair, Quantity::kTranslation, pair.sigma.translation));
    if (!HasUnobservable(pair.unobservable, Quantity::kTimeOffset)) {
      largest.time_offset = std::max(largest.time_offset, pair.sigma.time_offset);
    }
  }
  for (const SensorResult& sensor : result.sensors) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto i = static_cast<Eigen::Index>(k);
      if (sensor.rotation_observable[k]) {
        largest.rotation = std::max(largest.rotation, sensor.sigma.rotation[i]);
      }
      if (sensor.translation_observable[k]) {
        largest.translation = std::max(largest.translation, sensor.sigma.translation[i]);
      }
    }
    if (sensor.time_offset_observable) {
      largest.time_offset = std::max(largest.time_offset, sensor.sigma.time_offset);
    }
  }
  return largest;
}

std::string UseCommand(const std::filesystem::path& place) {
  return "roslaunch " +
         ShellQuoted((std::filesystem::absolute(place) / "static_transforms.launch").lexically_normal());
}

std::vector<std::string> NextSteps(const CalibrationResult& result, const std::filesystem::path& place) {
  using Quantity = UnobservableDirection::Quantity;
  std::vector<std::string> steps;
  for (const QualityCheck& check : result.checks) {
    if (check.Passed() || !check.refuses) continue;
    const std::string step =
        check.name + (check.sensor.empty() ? "" : " of " + check.sensor) + ": " + check.remedy;
    if (!result.Trusted()) steps.push_back(step);
  }
  if (!result.Usable() || !result.root.empty()) {
    steps.push_back(
        "Record again with turns: a figure of eight in a vehicle, or turns about all three axes by hand, "
        "among "
        "walls and poles, for about a minute.");
    steps.push_back(
        "Or give T_imu_sensor with sigma in the rig file: it decides the directions that the drive does not "
        "determine.");
  }
  if (result.Usable() && HasUnobservable(result, Quantity::kTranslation)) {
    steps.push_back(
        "Unobservable translations: measure them by ruler or drawing and give them in the rig file with "
        "their "
        "sigma, or drive over kerbs and ramps so that the vehicle also rolls and pitches.");
  }
  if (HasUnobservable(result, Quantity::kRotation)) {
    steps.push_back("Unobservable rotations: turn about more than one axis, in both directions.");
  }
  if (HasUnobservable(result, Quantity::kTimeOffset)) {
    steps.push_back("Unobservable time offsets: change the rate of turning quickly, several times.");
  }
  for (const ResidualSummary& residual : result.residuals) {
    if (residual.inlier_share < 0.8) {
      steps.push_back(
          residual.sensor + ": only " + FixedNumber(100.0 * residual.inlier_share, 0) +
          " percent of its residuals are inliers; look for moving objects, its own vehicle in view, or a "
          "wrong point time.");
    }
  }
  if (result.Usable()) {
    steps.push_back("Use it: " + UseCommand(place) +
                    ", or include sensors.urdf.xacro in the vehicle's model.");
    steps.push_back(
        "Calibrate a second recording and compare: the two should differ by no more than their sigmas say.");
  }
  return steps;
}

}  // namespace mlic
