#include "mlic_core/io/report/report_figures.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mlic_core/io/result/export_frames.h"
#include "mlic_core/io/text_file.h"

namespace mlic {
namespace {

// Constants of this file, from: structural, how the report looks.

// Size of the plots, and the frame that their axes leave.
constexpr double kWidth = 340.0, kHeight = 150.0;
constexpr double kLeft = 40.0, kRight = 10.0, kTop = 8.0, kBottom = 30.0;

double AcrossAt(double share) { return kLeft + share * (kWidth - kLeft - kRight); }
double DownAt(double share) { return kHeight - kBottom - share * (kHeight - kTop - kBottom); }

std::string Text(double x, double y, const std::string& anchor, const std::string& text) {
  return "<text x=\"" + SvgNumber(x) + "\" y=\"" + SvgNumber(y) + "\" text-anchor=\"" + anchor + "\">" +
         EscapeXml(text) + "</text>";
}

std::string Line(double x1, double y1, double x2, double y2, const std::string& style) {
  return "<line x1=\"" + SvgNumber(x1) + "\" y1=\"" + SvgNumber(y1) + "\" x2=\"" + SvgNumber(x2) +
         "\" y2=\"" + SvgNumber(y2) + "\" class=\"" + style + "\"/>";
}

std::string Open(const std::string& label) {
  return "<svg viewBox=\"0 0 " + SvgNumber(kWidth) + " " + SvgNumber(kHeight) +
         "\" role=\"img\" aria-label=\"" + EscapeXml(label) + "\">";
}

std::string Axis(const std::string& label) {
  return Line(kLeft, DownAt(0), kWidth - kRight, DownAt(0), "axis") +
         Text(AcrossAt(0.5), kHeight - 4.0, "middle", label);
}

// 1, 2 or 5 times a power of ten, about a fifth of the span or larger.
double TickStep(double span) {
  const double rough = span / 5.0;
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= rough) return factor * power;
  }
  return 10.0 * power;
}

}  // namespace

std::string SvgNumber(double value) { return FixedNumber(value, 1); }

std::string SensorColor(std::size_t sensor) {
  static const char* const kColors[] = {"#2f6fb5", "#e0812b", "#3a9b57", "#b5446e",
                                        "#7a5bb8", "#1f9aa6", "#a68a1f", "#7c6a5d"};
  return kColors[sensor % 8];
}

std::string HistogramFigure(const ResidualSummary& residual, const std::string& color) {
  const std::vector<double>& counts = residual.histogram;
  double total = 0.0;
  for (const double count : counts) total += count;
  if (total <= 0.0) return "<p class=\"none\">no residuals</p>";
  const double width = 10.0 / static_cast<double>(counts.size());  // of a bin, in sigmas
  double highest = 1.0 / std::sqrt(2.0 * M_PI);
  for (const double count : counts) highest = std::max(highest, count / (total * width));
  std::string svg = Open("histogram of the residuals of " + residual.sensor);
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const double share = counts[i] / (total * width * highest);
    const double left = AcrossAt(static_cast<double>(i) / counts.size());
    const double right = AcrossAt(static_cast<double>(i + 1) / counts.size());
    svg += "<rect x=\"" + SvgNumber(left) + "\" y=\"" + SvgNumber(DownAt(share)) + "\" width=\"" +
           SvgNumber(std::max(0.5, right - left - 0.6)) + "\" height=\"" +
           SvgNumber(DownAt(0) - DownAt(share)) + "\" fill=\"" + color + "\" fill-opacity=\"0.75\"/>";
  }
  std::string points;
  for (int i = 0; i <= 100; ++i) {
    const double x = -5.0 + 0.1 * i;
    const double density = std::exp(-0.5 * x * x) / std::sqrt(2.0 * M_PI);
    points += SvgNumber(AcrossAt(0.01 * i)) + "," + SvgNumber(DownAt(density / highest)) + " ";
  }
  svg += "<polyline points=\"" + points + "\" class=\"expected\"/>";
  for (int tick = -4; tick <= 4; tick += 2) {
    svg += Text(AcrossAt((tick + 5) / 10.0), DownAt(0) + 12.0, "middle", std::to_string(tick));
  }
  return svg + Axis("residual / assumed sigma") + "</svg>";
}

std::string OverTimeFigure(const ResidualSummary& residual, const std::string& color) {
  const std::vector<double>&times = residual.over_time_seconds, &rms = residual.over_time_rms;
  const std::size_t count = std::min(times.size(), rms.size());
  if (count < 2 || residual.sigma <= 0.0) return "<p class=\"none\">no time series</p>";
  Plot plot{"residuals of " + residual.sensor + " over time", "time in the drive, s", {{color, {}}}, {1.0}};
  for (std::size_t i = 0; i < count; ++i) {
    plot.curves[0].points.emplace_back(times[i], rms[i] / residual.sigma);
  }
  return PlotFigure(plot);
}

std::string PlotFigure(const Plot& plot) {
  const auto up = [&](double value) { return plot.logarithmic ? std::log10(value) : value; };
  const auto drawn = [&](double value) { return std::isfinite(value) && (!plot.logarithmic || value > 0.0); };
  const double none = std::numeric_limits<double>::infinity();
  double begin = none, end = -none, low = plot.logarithmic ? none : 0.0,
         high = plot.logarithmic ? -none : 0.0;
  const auto include = [&](double value) {
    low = std::min(low, up(value));
    high = std::max(high, up(value));
  };
  for (const double level : plot.levels) include(level);
  for (const Curve& curve : plot.curves) {
    for (const auto& [x, y] : curve.points) {
      if (!drawn(y)) continue;
      include(y);
      begin = std::min(begin, x);
      end = std::max(end, x);
    }
  }
  if (begin > end) return "<p class=\"none\">nothing to draw</p>";
  const double span = std::max(1e-12, end - begin), height = std::max(1e-12, 1.05 * (high - low));
  const auto x_at = [&](double x) { return AcrossAt((x - begin) / span); };
  const auto y_at = [&](double value) { return DownAt((up(value) - low) / height); };
  std::string svg = Open(plot.label);
  for (const double level : plot.levels) {
    svg += Line(kLeft, y_at(level), kWidth - kRight, y_at(level), "guide");
  }
  for (const Curve& curve : plot.curves) {
    std::string points;
    for (const auto& [x, y] : curve.points) {
      if (drawn(y)) points += SvgNumber(x_at(x)) + "," + SvgNumber(y_at(y)) + " ";
    }
    svg += "<polyline points=\"" + points + "\" fill=\"none\" stroke=\"" + curve.color +
           "\" stroke-width=\"" + (curve.dashed ? "1\" stroke-dasharray=\"3 3" : "1.6") + "\"/>";
  }
  const double across = TickStep(span);
  for (double x = across * std::ceil(begin / across); x <= end + 1e-9 * span; x += across) {
    svg += Text(x_at(x), DownAt(0) + 12.0, "middle", ShortNumber(x, 6));
  }
  const double step = plot.logarithmic ? std::max(1.0, std::ceil(height / 5.0)) : TickStep(height);
  for (double value = step * std::ceil(low / step); value <= low + height; value += step) {
    const double shown = std::abs(value) < 1e-9 * step ? 0.0 : value;
    svg += Text(kLeft - 5.0, DownAt((value - low) / height) + 3.5, "end",
                ShortNumber(plot.logarithmic ? std::pow(10.0, shown) : shown, 3));
  }
  return svg + Axis(plot.across) + "</svg>";
}

}  // namespace mlic
