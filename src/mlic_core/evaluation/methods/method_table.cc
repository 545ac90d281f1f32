#include "mlic_core/evaluation/methods/method_table.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "mlic_core/common/padded.h"

namespace mlic {
namespace {

constexpr double kNotGiven = std::numeric_limits<double>::quiet_NaN();  // from: structural

// Of one sensor or pair by one method; not a number where it gives none.
struct Sizes {
  double rotation_deg = kNotGiven, translation = kNotGiven, along_observable = kNotGiven,
         time_offset = kNotGiven;
};

Sizes SizesOf(const std::vector<PoseError>& errors, const PoseError& row) {
  const auto error =
      std::find_if(errors.begin(), errors.end(), [&](const PoseError& e) { return e.name == row.name; });
  if (error == errors.end()) return {};
  double squares = 0.0;
  for (int k = 0; k < 3; ++k) {
    if (row.translation_observable[static_cast<std::size_t>(k)])
      squares += std::pow(error->translation[k], 2);
  }
  return {error->RotationDegrees(), error->translation.norm(), std::sqrt(squares),
          error->time_offset ? std::abs(*error->time_offset) : kNotGiven};
}

std::string Field(double value, const char* format, const char* none) {
  char text[48];
  std::snprintf(text, sizeof(text), format, value);
  return std::isnan(value) ? none : text;
}

constexpr std::size_t kNameWidth = 30;  // from: structural

template <typename Add>
void ForEachRow(const std::vector<MethodErrors>& methods, const Add& add) {
  if (methods.empty()) return;
  for (const PoseError& row : methods.front().errors.sensors) add("sensor", &TruthComparison::sensors, row);
  for (const PoseError& row : methods.front().errors.pairs) add("pair", &TruthComparison::pairs, row);
}

}  // namespace

std::string TableOf(const std::vector<MethodErrors>& methods) {
  std::string title = Padded("", kNameWidth), units = title;
  for (const MethodErrors& method : methods) {
    title += "  " + Padded(method.method, 26);
    units += "       deg       mm       ms";
  }
  std::string table = title.substr(0, title.find_last_not_of(' ') + 1) + "\n" + units + "\n";
  bool partly = false;
  ForEachRow(methods, [&](const char*, auto errors, const PoseError& row) {
    const auto& shown = row.translation_observable;
    const bool all = std::all_of(shown.begin(), shown.end(), [](bool axis) { return axis; });
    partly |= !all;
    std::string line = Padded(row.name + (all ? "" : " *"), kNameWidth);
    for (const MethodErrors& method : methods) {
      const Sizes sizes = SizesOf(method.errors.*errors, row);
      line += Field(sizes.rotation_deg, "%10.4f", "         -") +
              Field(1e3 * sizes.along_observable, "%9.2f", "        -") +
              Field(1e3 * sizes.time_offset, "%9.4f", "        -");
    }
    table += line + "\n";
  });
  if (partly) table += "*: along the axes that the drive shows; the others are the guess's\n";
  return table;
}

std::string CsvOf(const std::vector<MethodErrors>& methods) {
  std::string csv = "method,kind,name,rotation_deg,translation,translation_observable,time_offset\n";
  ForEachRow(methods, [&](const char* kind, auto errors, const PoseError& row) {
    for (const MethodErrors& method : methods) {
      const Sizes sizes = SizesOf(method.errors.*errors, row);
      csv += method.method + "," + kind + "," + row.name;
      for (const double value :
           {sizes.rotation_deg, sizes.translation, sizes.along_observable, sizes.time_offset}) {
        csv += "," + Field(value, "%.9g", "nan");
      }
      csv += "\n";
    }
  });
  return csv;
}

}  // namespace mlic
