#include "mlic_ros/panel/panel_model.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "mlic_ros/display/status_text.h"

namespace mlic {
namespace {

// Changes beyond say only that there is no sigma yet. from: structural
constexpr double kLargestChange = 1e6, kLeastValue = 1e-3;

std::string Text(const char* format, double value) {
  char text[48];
  std::snprintf(text, sizeof(text), format, value);
  return text;
}

std::vector<CurvePoint> Curve(const std::vector<double>& values, double largest, const Status& status) {
  std::vector<CurvePoint> curve;
  for (std::size_t k = 0; k < values.size(); ++k) {
    if (!std::isfinite(values[k])) continue;
    const int stage = k < status.solve_stages.size() ? status.solve_stages[k] : 0;
    curve.push_back({static_cast<int>(k), std::clamp(values[k], kLeastValue, largest), stage});
  }
  return curve;
}

double Length(double x, double y, double z) { return std::sqrt(x * x + y * y + z * z); }

template <typename Array>
double Largest(const Array& values) {
  return *std::max_element(values.begin(), values.end());
}

std::string StateText(const SensorStatus& sensor, bool running) {
  switch (sensor.state) {
    case SensorStatus::ESTIMATED:
      return running ? "converging" : "estimated";
    case SensorStatus::TRUSTED:
      return sensor.reason.empty() ? "trusted" : "trusted *";
    case SensorStatus::HELD:
      return "held";
    case SensorStatus::REJECTED:
      return "rejected";
    default:
      return running ? "waiting" : "not found";
  }
}

std::string FromGuess(const SensorStatus& sensor) {
  if (!sensor.has_guess) return "no guess";
  const geometry_msgs::Vector3 &a = sensor.transform.translation, &b = sensor.guess.translation;
  const geometry_msgs::Quaternion &p = sensor.transform.rotation, &q = sensor.guess.rotation;
  const double cosine = std::abs(p.x * q.x + p.y * q.y + p.z * q.z + p.w * q.w);
  const double degrees = 2.0 * std::acos(std::min(1.0, cosine)) * 180.0 / M_PI;
  return ShortNumberText(degrees) + " deg, " +
         ShortNumberText(1e3 * Length(a.x - b.x, a.y - b.y, a.z - b.z)) + " mm";
}

}  // namespace

std::vector<CurvePoint> ChangeCurve(const Status& status) {
  return Curve(status.changes, kLargestChange, status);
}

std::vector<CurvePoint> SigmaCurve(const Status& status) {
  std::vector<double> millimetres;
  for (const double sigma : status.largest_sigmas) millimetres.push_back(1e3 * sigma);
  return Curve(millimetres, HUGE_VAL, status);
}

std::vector<CurvePoint> ResidualCurve(const Status& status) {
  return Curve(status.mean_squares, HUGE_VAL, status);
}

double LogAxis::Place(double value) const {
  const double power = std::log10(std::max(value, std::pow(10.0, lowest)));
  return std::clamp((power - lowest) / (highest - lowest), 0.0, 1.0);
}

LogAxis FitLogAxis(const std::vector<CurvePoint>& curve, double around) {
  double least = around, most = around;
  for (const CurvePoint& point : curve) {
    least = std::min(least, point.value);
    most = std::max(most, point.value);
  }
  LogAxis axis;
  axis.lowest = static_cast<int>(std::floor(std::log10(least)));
  axis.highest = std::max(axis.lowest + 1, static_cast<int>(std::ceil(std::log10(most))));
  return axis;
}

std::size_t FreestBox(const std::vector<Box>& boxes, const std::vector<Place>& curve) {
  constexpr int kParts = 64;  // of a line between two points; from: structural
  const auto passes = [&](const Box& box) {
    double inside = 0.0;
    for (std::size_t k = 0; k + 1 < curve.size(); ++k) {
      const double dx = curve[k + 1].x - curve[k].x, dy = curve[k + 1].y - curve[k].y;
      for (int part = 0; part <= kParts; ++part) {
        const double share = static_cast<double>(part) / kParts;
        const double x = curve[k].x + share * dx - box.left, y = curve[k].y + share * dy - box.top;
        if (x >= 0.0 && x <= box.width && y >= 0.0 && y <= box.height) inside += std::hypot(dx, dy) / kParts;
      }
    }
    return inside;
  };
  std::size_t best = 0;
  for (std::size_t k = 1; k < boxes.size(); ++k) {
    if (passes(boxes[k]) < passes(boxes[best])) best = k;
  }
  return best;
}

std::string ShortNumberText(double value) {
  const double size = std::abs(value);
  if (size >= 1e7) return Text("%.1e", value);
  if (size >= 10.0) return Text("%.0f", value);
  if (size >= 1.0) return Text("%.1f", value);
  return size >= 0.01 ? Text("%.2f", value) : Text("%.4f", value);
}

const std::array<const char*, SensorRow::kColumns>& SensorRow::Titles() {
  static const std::array<const char*, kColumns> kTitles{"sensor",     "state",     "offset\nms",
                                                         "sigma\ndeg", "sigma\nmm", "from\nthe guess"};
  return kTitles;
}

std::vector<SensorRow> SensorRows(const Status& status) {
  const bool running = status.state == Status::RUNNING;
  std::vector<SensorRow> rows;
  for (const SensorStatus& sensor : status.sensors) {
    SensorRow row;
    row.name = sensor.name;
    row.frame = sensor.frame_id;
    row.state = sensor.state;
    row.note = sensor.reason;
    row.shown = std::find(status.hidden.begin(), status.hidden.end(), sensor.name) == status.hidden.end();
    row.cells[0] = sensor.name;
    row.cells[1] = StateText(sensor, running);
    const bool found = IsFound(sensor.state);
    for (std::size_t cell = 2; !found && cell < row.cells.size(); ++cell) row.cells[cell] = "-";
    if (found) {
      row.cells[2] = Text("%.2f", 1e3 * sensor.time_offset);
      row.cells[3] = sensor.has_sigma ? ShortNumberText(Largest(sensor.sigma_rotation_deg)) : "-";
      row.cells[4] = sensor.has_sigma ? ShortNumberText(1e3 * Largest(sensor.sigma_translation)) : "-";
      row.cells[5] = FromGuess(sensor);
    }
    rows.push_back(row);
  }
  return rows;
}

std::string MessageLines(const Status& status) {
  std::string lines;
  double degrees = 0.0, metres = 0.0;
  int given = 0, noted = 0;
  for (const SensorStatus& sensor : status.sensors) {
    if (sensor.state != SensorStatus::TRUSTED || !sensor.has_sigma) continue;
    ++given;
    // Along a direction that the drive does not show it would be the guess's.
    if (!sensor.reason.empty()) {
      ++noted;
      continue;
    }
    degrees = std::max(degrees, Largest(sensor.sigma_rotation_deg));
    metres = std::max(metres, Largest(sensor.sigma_translation));
  }
  if (given > 0) lines = std::to_string(given) + (given == 1 ? " sensor" : " sensors");
  if (given > noted)
    lines += ", worst sigma " + ShortNumberText(degrees) + " deg, " + ShortNumberText(1e3 * metres) + " mm";
  if (noted > 0) lines += ", * not all of it shown by the drive";
  if (given > 0) lines += "\n";
  const std::string verdict = VerdictWord(status) + ": ";  // stands above already
  for (std::size_t k = 0; k < status.messages.size() && k < 3; ++k) {
    const std::string& line = status.messages[k];
    lines += (line.rfind(verdict, 0) == 0 ? line.substr(verdict.size()) : line) + "\n";
  }
  return lines;
}

std::string LegendHtml(const Status& status) {
  std::string html;
  for (std::size_t k = 0; k < status.legend.size() && k < status.legend_colours.size(); ++k) {
    char square[64];
    std::snprintf(square, sizeof(square), "<span style='color:#%06x'>&#9632;</span>&nbsp;",
                  static_cast<unsigned>(status.legend_colours[k]));
    html += square;
    // An entry stays in one line.
    for (const char letter : status.legend[k]) html += letter == ' ' ? "&nbsp;" : std::string(1, letter);
    html += " &nbsp; ";
  }
  return html;
}

std::string RoundText(const Status& status) {
  if (status.rounds == 0) return "";
  const std::string of = " of " + std::to_string(status.rounds);
  return status.shown_round == 0 ? "latest" + of : "round " + std::to_string(status.shown_round) + of;
}

std::optional<Viewpoint> ViewOfMap(const Status& status) {
  constexpr double kRadiiAway = 2.9;  // from: structural, a field of view of 45 deg and some margin
  if (status.map_radius <= 0.0f) return std::nullopt;
  const geometry_msgs::Point& center = status.map_center;
  return Viewpoint{center.x, center.y, center.z, kRadiiAway * status.map_radius};
}

Viewpoint ViewOfSensor(const Status& status) {
  constexpr double kLeastDistance = 0.5, kRigsAway = 3.0;  // m; from: structural
  double rig = 0.0;
  for (const SensorStatus& sensor : status.sensors) {
    const geometry_msgs::Vector3& p = sensor.transform.translation;
    rig = std::max(rig, Length(p.x, p.y, p.z));
  }
  return {0.0, 0.0, 0.0, std::max(kLeastDistance, kRigsAway * rig)};
}

}  // namespace mlic
