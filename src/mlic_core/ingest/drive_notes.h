#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "mlic_core/ingest/stamp_check.h"

namespace mlic {

// Text for people about one topic: counts and what was left out; and what is odd.
struct DriveNotes {
  std::vector<std::string> lines;
  std::vector<std::string> warnings;
};

// A number as printf writes it.
std::string Number(double value, const char* format = "%.4g");

// "; 3 out of order" and the like, only where there is something to say.
std::string CountText(std::size_t count, const std::string& what);

// What is odd about the stamps, in that form.
std::string StampText(const StampReport& report);

// The report's warnings with the topic before them.
void AddWarnings(const std::string& topic, const StampReport& report, DriveNotes& notes);

}  // namespace mlic
