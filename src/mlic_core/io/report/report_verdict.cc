#include "mlic_core/io/report/report_verdict.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "mlic_core/common/angles.h"
#include "mlic_core/io/result/export_frames.h"
#include "mlic_core/io/result/result_names.h"
#include "mlic_core/io/text_file.h"

namespace mlic {
namespace {

bool HasUnobservable(const std::vector<UnobservableDirection>& directions,
                     UnobservableDirection::Quantity quantity) {
  return std::any_of(directions.begin(), directions.end(),
                     [&](const UnobservableDirection& direction) { return direction.quantity == quantity; });
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
  std::string html = "<div class=\"tiles\">";
  if (!result.sensors.empty()) {
    html += Tile(std::to_string(result.sensors.size()),
                 result.sensors.size() == 1 ? "sensor calibrated" : "sensors calibrated");
  }
  if (!result.root.empty()) html += Tile(std::to_string(result.pairs.size()), "pairs of sensors");
  if (!result.sensors.empty() || !result.root.empty()) {
    html += sigmas.rotation > 0.0 ? Tile(FixedNumber(kDegreesPerRadian * sigmas.rotation, 4) + "&deg;",
                                         "largest &sigma; of a rotation")
                                  : Tile("no", "rotation is observable");
    html += sigmas.translation > 0.0 ? Tile(FixedNumber(1e3 * sigmas.translation, 1) + " mm",
                                            "largest &sigma; of an observable translation")
                                     : Tile("no", "translation is observable");
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
  html += "</div>\n";
  if (sigmas.rotation > 0.0) {
    html +=
        "<p class=\"note\">&sigma; (<dfn>sigma</dfn>): one standard deviation. <dfn>Observable</dfn>: "
        "determined "
        "by the data alone, to 50 mm, 0.5&deg; or 5 ms and to better than the sigma of the guess; where a "
        "direction is <b>unobservable</b> the <dfn>guess</dfn>, the rig file's initial pose, decides.</p>\n";
  }
  return html;
}

std::string List(const std::vector<std::string>& lines) {
  std::string html = "<ul>\n";
  for (const std::string& line : lines) html += "<li>" + EscapeXml(line) + "</li>\n";
  return html + "</ul>\n";
}

}  // namespace

std::string VerdictBlock(const CalibrationResult& result) {
  const bool unobservable =
      std::any_of(result.sensors.begin(), result.sensors.end(),
                  [](const SensorResult& sensor) { return !sensor.unobservable.empty(); });
  const bool unshown = std::any_of(result.pairs.begin(), result.pairs.end(),
                                   [](const PairResult& pair) { return !pair.unobservable.empty(); });
  const std::string name = VerdictName(result.verdict);
  std::string title = name;
  title[0] = static_cast<char>(std::toupper(title[0]));
  std::string html = "<section class=\"verdict " + name + "\">\n<h1>" + title + "</h1>\n<p class=\"lead\">";
  if (!result.root.empty()) {
    html +=
        "The pairs of sensors below can be used, and launch file and URDF, which are about " +
        EscapeXml(result.root) + ". Nothing ties them to the IMU:</p>\n" + List(result.reasons) +
        (unshown ? "<p>Some directions of the pairs, marked <b>unobservable</b> below, are not determined by "
                   "this drive either: there the given guess decides.</p>\n"
                 : "");
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
        "by this drive: there the given guess decides.</p>\n";
  } else {
    html += "The calibration can be used: the drive determines every direction of every sensor.</p>\n";
  }
  const auto failed = std::count_if(result.checks.begin(), result.checks.end(),
                                    [](const QualityCheck& check) { return !check.Passed(); });
  if (!result.warnings.empty() || failed > 0) {
    const std::size_t warnings = result.warnings.size();
    html += "<p><a href=\"#checks\">" + std::to_string(warnings) +
            (warnings == 1 ? " warning; " : " warnings; ") + std::to_string(failed) + " of " +
            std::to_string(result.checks.size()) + " checks not passed</a></p>\n";
  }
  return html + Tiles(result) + "</section>\n";
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

}  // namespace mlic
