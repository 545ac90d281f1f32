#include "mlic_core/io/report/report_checks.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "mlic_core/io/result/export_frames.h"
#include "mlic_core/io/text_file.h"

namespace mlic {
namespace {

// Above 1 beyond the limit; the larger, the worse.
double Strain(const QualityCheck& check) {
  const bool most = check.bound == QualityCheck::Bound::kMost;
  const double strain = most ? check.value / check.limit : check.limit / std::max(1e-12, check.value);
  return std::isfinite(strain) ? strain : std::numeric_limits<double>::infinity();
}

// Three digits, but counts as they are.
std::string Shown(double value) {
  return std::abs(value) >= 1000.0 && std::isfinite(value) ? FixedNumber(value, 0) : ShortNumber(value, 3);
}

std::string Outcome(const QualityCheck& check) {
  if (check.Passed()) return "<span class=\"good\">&#10003; passed</span>";
  return check.refuses ? "<b class=\"bad\">&#10007; failed</b>" : "<b class=\"fair\">! warning</b>";
}

std::string Row(const QualityCheck& check, const std::string& sensor, bool explained) {
  const std::string limit = (check.bound == QualityCheck::Bound::kMost ? "&le; " : "&ge; ") +
                            Shown(check.limit) + " " + EscapeXml(check.unit);
  return "<tr><td data-label=\"result\">" + Outcome(check) + "</td><td data-label=\"check\"><b>" +
         EscapeXml(check.name) + "</b>" +
         (explained ? "<small>" + EscapeXml(MeaningOf(check.name)) + "</small>" : "") +
         "</td><td data-label=\"sensor\">" + sensor + "</td><td class=\"n\" data-label=\"value\">" +
         Shown(check.value) + "</td><td data-label=\"limit\">" + limit +
         "</td><td data-label=\"what to do\">" +
         (check.Passed() ? ""
                         : EscapeXml(check.failure + (check.failure.empty() ? "" : ": ") + check.remedy)) +
         "</td></tr>\n";
}

std::string Table(const std::string& rows) {
  return "<table class=\"stack checks\"><thead><tr><th>result</th><th>check and what it measures</th>"
         "<th>sensor</th><th>value</th><th>limit</th><th>what to do</th></tr></thead>\n<tbody>" +
         rows + "</tbody></table>\n";
}

// Each that failed, then one row for each kind of those that passed, of the sensor nearest to the limit.
std::string Summary(const std::vector<QualityCheck>& checks) {
  std::string failed, passed;
  std::vector<std::string> kinds;
  for (const QualityCheck& check : checks) {
    if (std::find(kinds.begin(), kinds.end(), check.name) == kinds.end()) kinds.push_back(check.name);
    if (!check.Passed()) failed += Row(check, EscapeXml(check.sensor), true);
  }
  for (const std::string& kind : kinds) {
    const QualityCheck* worst = nullptr;
    int count = 0;
    for (const QualityCheck& check : checks) {
      if (check.name != kind || !check.Passed()) continue;
      ++count;
      if (worst == nullptr || Strain(check) > Strain(*worst)) worst = &check;
    }
    if (worst == nullptr) continue;
    const std::string others =
        count > 1 ? "<small>of " + std::to_string(count) + ", nearest to its limit</small>" : "";
    passed += Row(*worst, EscapeXml(worst->sensor) + others, true);
  }
  return Table(failed + passed);
}

}  // namespace

std::string MeaningOf(const std::string& check) {
  static const std::map<std::string, std::string> kMeanings = {
      {"convergence", "by how many sigmas the last round (association and solve) moved the calibration"},
      {"pairs_convergence",
       "by how many sigmas the last round moved LiDARs that are calibrated to each other without the IMU"},
      {"excitation_rotation", "sigma of the rotation that the data alone show least"},
      {"excitation_translation", "sigma of the translation that the data alone show least"},
      {"excitation_time_offset", "sigma of the time offset from the data alone"},
      {"agreement_with_guess", "distance from the rig file's guess, in the guess's sigmas"},
      {"stamps", "time errors of scans or images beyond their noise"},
      {"ranges", "what all ranges of the LiDAR seem to err by"},
      {"lens_reach", "how far towards the image's corners the lens model holds"},
      {"whiteness", "what the residuals of one sixtieth of the drive have in common"},
      {"halves", "by how much two parts of the drive, calibrated apart, differ"},
      {"coverage_image", "share of the image in which landmarks are seen"},
      {"reprojection_spread", "scatter of the reprojection errors against the noise of the features"},
      {"coverage_directions",
       "points on planes that face the rarest direction of space, against the most "
       "frequent"},
      {"planes", "planes of the map"},
      {"pairs_planes", "planes of the map, of LiDARs calibrated to each other without the IMU"},
      {"imu_slow_errors", "means of the IMU's residuals over 1 to 10 s against its noise"},
      {"imu_state", "biases and lag of the IMU against those that IMUs have"},
      {"imu_agreement", "largest mean of a second's IMU residuals that stands out; 0 if none does"},
      {"map_matches", "matches of the photos with the LiDAR map"},
      {"held_out_matches", "median error of the matches with the LiDAR map that no solve used"},
  };
  const auto found = kMeanings.find(check);
  return found == kMeanings.end() ? "" : found->second;
}

std::string ChecksTable(const CalibrationResult& result) {
  std::string html;
  if (!result.warnings.empty()) {
    html += "<div class=\"callout\"><b>Warnings</b> (they leave the verdict as it is)<ul>\n";
    for (const std::string& warning : result.warnings) html += "<li>" + EscapeXml(warning) + "</li>\n";
    html += "</ul></div>\n";
  }
  const std::vector<QualityCheck>& checks = result.checks;
  if (checks.empty()) return html;
  std::size_t passed = 0;
  std::string all;
  for (const QualityCheck& check : checks) {
    passed += check.Passed() ? 1 : 0;
    all += Row(check, EscapeXml(check.sensor), false);
  }
  const std::string total = std::to_string(checks.size());
  html +=
      "<p>" + std::to_string(passed) + " of " + total +
      " checks passed. A <dfn>check</dfn> is one thing that could be wrong, measured against a limit. One "
      "that failed rejects its sensor, or the whole where it names none; a warning does not.</p>\n" +
      Summary(checks);
  return html + "<details><summary>all " + total + " checks, sensor by sensor</summary>\n" + Table(all) +
         "</details>\n";
}

}  // namespace mlic
