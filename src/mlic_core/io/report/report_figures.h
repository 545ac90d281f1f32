#pragma once

#include <string>
#include <utility>
#include <vector>

#include "mlic_core/result/result.h"

namespace mlic {

// Figures of the report, each a piece of HTML that needs nothing from outside.

// A coordinate in a drawing: to a tenth of a pixel.
std::string SvgNumber(double value);

// The colour of a sensor, "#rrggbb", by its index in CalibrationResult::sensors.
std::string SensorColor(std::size_t sensor);

// Residuals in units of their assumed sigma as bars, the normal distribution that they should follow as a
// line.
std::string HistogramFigure(const ResidualSummary& residual, const std::string& color);

// Root mean square over the drive in units of the assumed sigma.
std::string OverTimeFigure(const ResidualSummary& residual, const std::string& color);

// Quantities over one variable, in one frame.
struct Curve {
  std::string color;
  std::vector<std::pair<double, double>> points;
  bool dashed = false;
};
struct Plot {
  std::string label;   // for those who cannot see it
  std::string across;  // below it: the variable
  std::vector<Curve> curves;
  std::vector<double> levels;  // dashed lines across
  bool logarithmic = false;    // powers of ten upwards; what is not positive is left out
};
// Its range holds all curves and levels, of ones that are not logarithmic zero as well.
std::string PlotFigure(const Plot& plot);

}  // namespace mlic
