#include <cstdio>

#include "mlic_core/evaluation/harp.h"

namespace mlic {
namespace {

// What the last line compares with.
constexpr double kGoodRms = 0.5;      // px; from: definition
constexpr double kGoodLargest = 1.0;  // px; from: definition

std::string Row(const std::string& name, const HarpErrors& errors) {
  char text[160];
  std::snprintf(text, sizeof(text), ": %zu edges, %zu places, %.3f px rms, %.3f px at most\n", errors.lines,
                errors.places, errors.rms, errors.largest);
  return name + text;
}

std::string CsvRow(const std::string& intrinsics, const std::string& photo, const HarpErrors& errors) {
  char text[160];
  std::snprintf(text, sizeof(text), ",%zu,%zu,%.6f,%.6f\n", errors.lines, errors.places, errors.rms,
                errors.largest);
  return intrinsics + "," + photo + text;
}

}  // namespace

std::string TableOf(const std::vector<HarpColumn>& columns) {
  std::string table;
  for (const HarpColumn& column : columns) {
    const std::string of = columns.size() > 1 ? column.name + ", " : "";
    for (const HarpPhoto& photo : column.measurement.photos) table += Row(of + photo.name, photo.errors);
    table += Row(of + "all", column.measurement.all);
  }
  return table;
}

std::string CsvOf(const std::vector<HarpColumn>& columns) {
  std::string csv = "intrinsics,photo,lines,places,rms_px,largest_px\n";
  for (const HarpColumn& column : columns) {
    for (const HarpPhoto& photo : column.measurement.photos) {
      csv += CsvRow(column.name, photo.name, photo.errors);
    }
    csv += CsvRow(column.name, "all", column.measurement.all);
  }
  return csv;
}

std::string HistogramCsvOf(const std::vector<HarpColumn>& columns) {
  std::string csv = "intrinsics,from_px,to_px,places\n";
  char text[120];
  for (const HarpColumn& column : columns) {
    const HarpHistogram histogram = HistogramOf(column.measurement);
    const double width = 2.0 * histogram.limit / static_cast<double>(histogram.counts.size());
    for (std::size_t i = 0; i < histogram.counts.size(); ++i) {
      const double from = width * static_cast<double>(i) - histogram.limit;
      std::snprintf(text, sizeof(text), ",%.6f,%.6f,%zu\n", from, from + width, histogram.counts[i]);
      csv += column.name + text;
    }
  }
  return csv;
}

std::string Conclusion(const std::string& camera, const HarpMeasurement& measurement) {
  const HarpErrors& all = measurement.all;
  const bool good = all.rms <= kGoodRms && all.largest <= kGoodLargest;
  char text[200];
  std::snprintf(text, sizeof(text),
                ": straight edges are straight to %.2f px rms, %.2f px at most: %s %.1f px rms and %.1f px\n",
                all.rms, all.largest, good ? "within" : "beyond", kGoodRms, kGoodLargest);
  return camera + text;
}

}  // namespace mlic
