#include "mlic_core/io/report/report_use.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "mlic_core/io/result/export_frames.h"
#include "mlic_core/io/text_file.h"

namespace mlic {
namespace {

// Constants of this file, from: structural, how the report looks.

constexpr double kSide = 200.0, kRadius = 78.0;  // of the figure, and of its largest sector
constexpr std::size_t kShownRows = 12;           // of the table, before it is folded

// A sensor against the IMU, or a pair.
struct UseLine {
  std::string of, against;
  const std::vector<SigmaInUse>* uses;
};

std::vector<UseLine> LinesOf(const CalibrationResult& result, SigmaInUse::Where where) {
  std::vector<UseLine> lines;
  const auto add = [&](const std::string& of, const std::string& against,
                       const std::vector<SigmaInUse>& uses) {
    if (!uses.empty() && uses[0].where == where) lines.push_back({of, against, &uses});
  };
  for (const PairResult& pair : result.pairs) add(pair.b, pair.a, pair.in_use);
  for (const SensorResult& sensor : result.sensors) add(sensor.name, "the IMU", sensor.in_use);
  return lines;
}

// Three digits at most; "0.004" and not "0.00".
std::string Amount(double value) {
  return value >= 10.0 ? FixedNumber(value, 0) : value >= 0.1 ? FixedNumber(value, 2) : ShortNumber(value, 1);
}

std::string Distance(const SigmaInUse& use) { return ShortNumber(use.distance, 3) + " m"; }

// "median at 10 m, px"
std::string ColumnName(const std::string& which, double distance) {
  return which + " at " + ShortNumber(distance, 3) + " m, px";
}

// Both distances of a camera; a dash where the two cameras have nothing in common.
std::string Row(const UseLine& line, const std::vector<double>& distances) {
  std::string html = "<tr><td><b>" + EscapeXml(line.of) + "</b></td><td data-label=\"points known to\">" +
                     EscapeXml(line.against) + "</td>";
  for (const double distance : distances) {
    const auto found = std::find_if(line.uses->begin(), line.uses->end(),
                                    [&](const SigmaInUse& use) { return use.distance == distance; });
    const auto cell = [&](const std::string& which, double SigmaInUse::*value) {
      const std::string amount = found == line.uses->end() ? "&ndash;" : Amount((*found).*value);
      html += "<td class=\"n\" data-label=\"" + ColumnName(which, distance) + "\">" + amount + "</td>";
    };
    cell("median", &SigmaInUse::median);
    cell("worst", &SigmaInUse::worst);
  }
  return html + "</tr>\n";
}

std::string ImageTable(const std::vector<UseLine>& lines) {
  std::vector<double> distances;
  for (const UseLine& line : lines) {
    for (const SigmaInUse& use : *line.uses) distances.push_back(use.distance);
  }
  std::sort(distances.begin(), distances.end());
  distances.erase(std::unique(distances.begin(), distances.end()), distances.end());
  std::string head =
      "<div class=\"wide\"><table class=\"stack\"><thead><tr><th>in the image of</th><th>points known "
      "to</th>";
  for (const double distance : distances) {
    for (const std::string which : {"median", "worst"}) {
      head += "<th class=\"n\">" + ColumnName(which, distance) + "</th>";
    }
  }
  head += "</tr></thead>\n<tbody>";
  std::string html = head;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (i == kShownRows) {
      html += "</tbody></table></div>\n<details><summary>" + std::to_string(lines.size() - kShownRows) +
              " more</summary>\n" + head;
    }
    html += Row(lines[i], distances);
  }
  return html + "</tbody></table></div>\n" + (lines.size() > kShownRows ? "</details>\n" : "");
}

// x to the right and y down, of a bearing counterclockwise from straight up, in the figure.
std::string At(double radius, double bearing) {
  return FixedNumber(0.5 * kSide - radius * std::sin(bearing), 1) + " " +
         FixedNumber(0.5 * kSide - radius * std::cos(bearing), 1);
}

std::string Sectors(const SigmaInUse& use, double largest, const std::string& opacity) {
  std::string svg;
  const auto count = static_cast<double>(use.sectors.size());
  for (std::size_t k = 0; k < use.sectors.size(); ++k) {
    const double from = 2.0 * M_PI * static_cast<double>(k) / count, to = from + 2.0 * M_PI / count;
    const double radius = kRadius * use.sectors[k] / largest;
    const std::string r = FixedNumber(radius, 1);
    svg += "<path d=\"M" + At(0.0, 0.0) + " L" + At(radius, from) + " A" + r + " " + r + " 0 0 0 " +
           At(radius, to) + " Z\" fill=\"#2f6fb5\" fill-opacity=\"" + opacity +
           "\" class=\"sector\"><title>" + Amount(100.0 * use.sectors[k]) + " cm at " + Distance(use) +
           "</title></path>";
  }
  return svg;
}

std::string SectorFigure(const UseLine& line) {
  double largest = 1e-9;
  for (const SigmaInUse& use : *line.uses) {
    for (const double sigma : use.sectors) largest = std::max(largest, sigma);
  }
  const std::string middle = FixedNumber(0.5 * kSide, 1);
  std::string svg = "<svg class=\"rose\" role=\"img\" aria-label=\"sigmas by sector\" viewBox=\"0 0 " +
                    FixedNumber(kSide, 0) + " " + FixedNumber(kSide, 0) + "\"><circle cx=\"" + middle +
                    "\" cy=\"" + middle + "\" r=\"" + FixedNumber(kRadius, 1) +
                    "\" fill=\"none\" class=\"guide\"/>";
  // The farther points' sectors are the larger ones.
  for (auto use = line.uses->rbegin(); use != line.uses->rend(); ++use) {
    svg += Sectors(*use, largest, use == line.uses->rbegin() ? "0.35" : "0.9");
  }
  return svg + "<text x=\"" + middle + "\" y=\"13\" text-anchor=\"middle\">front</text><text x=\"" +
         FixedNumber(kSide - 2.0, 1) + "\" y=\"" + FixedNumber(kSide - 6.0, 1) +
         "\" text-anchor=\"end\">ring: " + Amount(100.0 * largest) + " cm</text></svg>";
}

std::string SpaceCards(const std::vector<UseLine>& lines) {
  std::string html = "<div class=\"grid roses\">\n";
  for (const UseLine& line : lines) {
    html += "<div class=\"card\"><h3>" + EscapeXml(line.of) + " to " + EscapeXml(line.against) + "</h3>\n" +
            SectorFigure(line);
    for (const SigmaInUse& use : *line.uses) {
      html += "<p class=\"note\">at " + Distance(use) + ": " + Amount(100.0 * use.median) + " cm, worst " +
              Amount(100.0 * use.worst) + " cm</p>";
    }
    html += "</div>\n";
  }
  return html + "</div>\n";
}

}  // namespace

std::string InUseSection(const CalibrationResult& result) {
  const std::vector<UseLine> image = LinesOf(result, SigmaInUse::Where::kImage);
  const std::vector<UseLine> space = LinesOf(result, SigmaInUse::Where::kSpace);
  std::string html;
  if (!image.empty()) {
    html +=
        "<p>By how far a point that another sensor knows misses its pixel: one sigma, along the direction in "
        "which it is largest, over the image. Pose and intrinsics together, with what their errors have in "
        "common.</p>\n" +
        ImageTable(image);
  }
  if (!space.empty()) {
    html +=
        "<p>By how far a point of a LiDAR misses its place in the frame of another, or of the IMU: one "
        "sigma, "
        "along the direction in which it is largest, around the horizon.</p>\n" +
        SpaceCards(space) +
        "<p class=\"legend\"><span><i style=\"background:#2f6fb5\"></i>points at the shorter "
        "distance</span><span><i style=\"background:#2f6fb5;opacity:.35\"></i>at the longer</span></p>\n"
        "<p class=\"note\">Seen from above; each sector reaches as far as its worst sigma, each figure has a "
        "scale of its own.</p>\n";
  }
  if (html.empty()) return "";
  return html +
         "<p class=\"note\">Not in these numbers: the noise of the measurement itself, and what the vehicle "
         "moves during an error of the time offset (speed times its sigma; rate times sigma, as an angle)."
         "</p>\n";
}

}  // namespace mlic
