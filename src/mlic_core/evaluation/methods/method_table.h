#pragma once

#include <string>
#include <vector>

#include "mlic_core/evaluation/truth_comparison.h"

namespace mlic {

// The errors of one method against the truth.
struct MethodErrors {
  std::string method;
  TruthComparison errors;
};

// The methods side by side, for people: degrees, millimetres, milliseconds; of sensors to the IMU the
// distance along the axes that the first method's calibration has as observable (others are the guess's in
// all). Sensors and pairs of the first method, a dash where another has none.
std::string TableOf(const std::vector<MethodErrors>& methods);

// method,kind,name,rotation_deg,translation,translation_observable,time_offset; degrees, metres, seconds, nan
// where a method gives nothing. translation_observable: as in the table.
std::string CsvOf(const std::vector<MethodErrors>& methods);

}  // namespace mlic
