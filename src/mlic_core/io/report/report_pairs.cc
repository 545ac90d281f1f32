#include "mlic_core/io/report/report_pairs.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "mlic_core/common/angles.h"
#include "mlic_core/io/report/report_tables.h"
#include "mlic_core/io/result/export_frames.h"
#include "mlic_core/io/text_file.h"
#include "mlic_core/sensors/observability_limits.h"

namespace mlic {
namespace {

// Shares of the limits, from which a cell takes the next colour. from: structural, how the report looks
constexpr double kShades[] = {0.02, 0.05, 0.1, 0.2, 0.5};

double ShareOfLimit(const PairResult& pair) {
  return std::max(pair.sigma.rotation.maxCoeff() / kRotationLimit,
                  pair.sigma.translation.maxCoeff() / kTranslationLimit);
}

// "shade0" to "shade5", or "marked".
std::string ColourOf(const PairResult& pair) {
  const double share = ShareOfLimit(pair);
  if (!pair.unobservable.empty() || share > 1.0) return "marked";
  return "shade" + std::to_string(std::count_if(std::begin(kShades), std::end(kShades),
                                                [&](double from) { return share > from; }));
}

// Along each axis, for who points at the cell.
std::string Title(const PairResult& pair) {
  const auto listed = [](const Eigen::Vector3d& v, double factor, int decimals) {
    return FixedNumber(factor * v.x(), decimals) + ", " + FixedNumber(factor * v.y(), decimals) + ", " +
           FixedNumber(factor * v.z(), decimals);
  };
  return pair.a + " / " + pair.b + ": rotation ± " + listed(pair.sigma.rotation, kDegreesPerRadian, 4) +
         "°, translation ± " + listed(pair.sigma.translation, 1e3, 2) + " mm, about and along the axes of " +
         pair.a + "; time offset ± " + FixedNumber(1e3 * pair.sigma.time_offset, 3) + " ms" +
         (ColourOf(pair) == "marked" ? "; in part unobservable" : "");
}

std::string PairCell(const PairResult* pair) {
  if (pair == nullptr) return "<td class=\"blank\">&ndash;</td>";
  const std::string colour = ColourOf(*pair);
  return "<td class=\"" + colour + "\" title=\"" + EscapeXml(Title(*pair)) + "\">" +
         FixedNumber(kDegreesPerRadian * pair->sigma.rotation.maxCoeff(), 3) + "&deg;<br>" +
         FixedNumber(1e3 * pair->sigma.translation.maxCoeff(), 1) + " mm" +
         (colour == "marked" ? "<br><b>unobserv.</b>" : "") + "</td>";
}

std::string Legend() {
  std::string html =
      "<p class=\"legend\">colour: share of the limits 0.5&deg; and 50 mm, beyond which a direction counts "
      "as unobservable: ";
  std::string from = "0";
  for (std::size_t i = 0; i < std::size(kShades); ++i) {
    const std::string to = FixedNumber(100.0 * kShades[i], 0);
    html += "<span class=\"key shade" + std::to_string(i) + "\">" + from + " to " + to + "%</span> ";
    from = to;
  }
  return html +
         "<span class=\"key shade5\">above</span> <span class=\"key marked\">unobservable</span></p>\n";
}

}  // namespace

std::string PairMatrix(const CalibrationResult& result) {
  std::vector<std::string> names;
  std::map<std::pair<std::string, std::string>, const PairResult*> pairs;
  for (const PairResult& pair : result.pairs) {
    for (const std::string& name : {pair.a, pair.b}) {
      if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    }
    pairs[{pair.a, pair.b}] = &pair;
  }
  std::string html = "<div class=\"wide\"><table class=\"matrix\"><thead><tr><th></th>";
  for (std::size_t b = 1; b < names.size(); ++b) {
    html += "<th title=\"" + EscapeXml(names[b]) + "\">" + std::to_string(b + 1) + "</th>";
  }
  html += "</tr></thead>\n<tbody>";
  for (std::size_t a = 0; a < names.size(); ++a) {
    html += "<tr><th>" + std::to_string(a + 1) + " " + EscapeXml(names[a]) + "</th>";
    for (std::size_t b = 1; b < names.size(); ++b) {
      if (b <= a) {
        html += "<td class=\"blank\"></td>";
        continue;
      }
      const auto found = pairs.find({names[a], names[b]});
      const auto turned = pairs.find({names[b], names[a]});
      html += PairCell(found != pairs.end()    ? found->second
                       : turned != pairs.end() ? turned->second
                                               : nullptr);
    }
    html += "</tr>\n";
  }
  return html +
         "</tbody></table></div>\n<p>How well each two sensors are known to each other: the largest sigma of "
         "rotation, and below it of translation, about and along the axes of the first. Point at a cell for "
         "all numbers. A pair can be known better than either is to the IMU, as both see one map.</p>\n" +
         Legend() + "<details><summary>poses of all " + std::to_string(result.pairs.size()) +
         " pairs</summary>\n" + PairTable(result) + "</details>\n";
}

}  // namespace mlic
