#include "mlic_core/ingest/drive_notes.h"

#include <cstdio>

namespace mlic {

std::string Number(double value, const char* format) {
  char text[64];
  std::snprintf(text, sizeof(text), format, value);
  return text;
}

std::string CountText(std::size_t count, const std::string& what) {
  return count == 0 ? "" : "; " + std::to_string(count) + " " + what;
}

std::string StampText(const StampReport& report) {
  return CountText(report.out_of_order, "out of order (sorted)") +
         CountText(report.duplicates, "with a repeated stamp (dropped)") +
         (report.missing == 0
              ? ""
              : CountText(report.missing, "missing, longest gap ") + Number(report.longest_gap) + " s");
}

void AddWarnings(const std::string& topic, const StampReport& report, DriveNotes& notes) {
  for (const std::string& warning : report.warnings)
    notes.warnings.push_back("topic " + topic + ": " + warning);
}

}  // namespace mlic
