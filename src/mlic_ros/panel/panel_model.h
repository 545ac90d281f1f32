#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "mlic/Status.h"

namespace mlic {

// What the panel shows of /mlic/status, as numbers and texts; no widget in it.

// One of a curve's values, over the solves in order.
struct CurvePoint {
  int solve = 0;  // from 0
  double value = 0.0;
  int stage = 0;  // number of the stage
};

// Each of the solves that it was measured in: largest change of a sensor in a round, in its sigmas; largest
// sigma of a sensor's translation, mm; mean squared residual.
std::vector<CurvePoint> ChangeCurve(const Status& status);
std::vector<CurvePoint> SigmaCurve(const Status& status);
std::vector<CurvePoint> ResidualCurve(const Status& status);

// A logarithmic axis over whole decades.
struct LogAxis {
  int lowest = 0, highest = 1;  // powers of ten at its ends
  // 0 at the lowest end, 1 at the highest; values beyond lie on the ends.
  double Place(double value) const;
};

// Around all values and `around`.
LogAxis FitLogAxis(const std::vector<CurvePoint>& curve, double around);

// In pixels.
struct Place {
  double x = 0.0, y = 0.0;
};
struct Box {
  double left = 0.0, top = 0.0, width = 0.0, height = 0.0;
};
// Of these boxes, of which there is one, the first that least of the curve passes through.
std::size_t FreestBox(const std::vector<Box>& boxes, const std::vector<Place>& curve);

// "0.04", "12", "3.1e+07"
std::string ShortNumberText(double value);

struct SensorRow {
  static constexpr int kColumns = 6;  // from: structural
  static const std::array<const char*, kColumns>& Titles();

  std::string name;
  std::string frame;
  bool shown = true;                        // in the scene
  std::uint8_t state = 0;                   // SensorStatus::state
  std::array<std::string, kColumns> cells;  // name, state, offset, sigmas, change from the guess
  std::string note;                         // what else to know of it
};

std::vector<SensorRow> SensorRows(const Status& status);

// Below the verdict: the worst sigmas of a result, and up to three of its reasons and warnings.
std::string MessageLines(const Status& status);

// What the points' colours say, each word in its colour.
std::string LegendHtml(const Status& status);
// "round 3 of 9", "latest of 9"; empty before the first.
std::string RoundText(const Status& status);

// Where to look from a distance.
struct Viewpoint {
  double x = 0.0, y = 0.0, z = 0.0;
  double distance = 0.0;  // m
};

// So that the map fills the scene; none before there is a map.
std::optional<Viewpoint> ViewOfMap(const Status& status);
// Likewise the sensor's surroundings on the rig, about its own frame.
Viewpoint ViewOfSensor(const Status& status);

}  // namespace mlic
