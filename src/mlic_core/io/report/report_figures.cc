#include "mlic_core/io/report/report_figures.h"

#include <algorithm>
#include <cmath>

#include "mlic_core/io/result/export_frames.h"
#include "mlic_core/io/text_file.h"

namespace mlic {
namespace {

// Constants of this file, from: structural, how the report looks.

// Size of the plots, and the frame that their axes leave.
constexpr double kWidth = 340.0, kHeight = 150.0;
constexpr double kLeft = 34.0, kRight = 10.0, kTop = 8.0, kBottom = 30.0;

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
  const double begin = times[0], span = std::max(1e-9, times[count - 1] - begin);
  double highest = 1.5;
  for (std::size_t i = 0; i < count; ++i) highest = std::max(highest, 1.1 * rms[i] / residual.sigma);
  std::string svg = Open("residuals of " + residual.sensor + " over time");
  svg += Line(kLeft, DownAt(1.0 / highest), kWidth - kRight, DownAt(1.0 / highest), "guide");
  std::string points;
  for (std::size_t i = 0; i < count; ++i) {
    points += SvgNumber(AcrossAt((times[i] - begin) / span)) + "," +
              SvgNumber(DownAt(rms[i] / residual.sigma / highest)) + " ";
  }
  svg += "<polyline points=\"" + points + "\" fill=\"none\" stroke=\"" + color + "\" stroke-width=\"1.6\"/>";
  const double across = TickStep(span), up = TickStep(highest);
  for (double t = across * std::ceil(begin / across); t <= begin + span; t += across) {
    svg += Text(AcrossAt((t - begin) / span), DownAt(0) + 12.0, "middle", ShortNumber(t, 6));
  }
  for (double value = 0.0; value <= highest; value += up) {
    svg += Text(kLeft - 5.0, DownAt(value / highest) + 3.5, "end", ShortNumber(value, 3));
  }
  return svg + Axis("time in the drive, s") + "</svg>";
}

}  // namespace mlic
