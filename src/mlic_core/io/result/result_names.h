#pragma once

#include <string>
#include <vector>

#include "mlic_core/result/result.h"

namespace mlic {

// The words of calibration.yaml, each list in the order of its enumeration.
const std::vector<std::string>& QuantityNames();       // UnobservableDirection::Quantity
const std::vector<std::string>& TypeNames();           // SensorResult::Type
const std::vector<std::string>& ImuAxesNames();        // ImuAxes
const std::vector<std::string>& SensorVerdictNames();  // trusted, held, rejected
const std::vector<std::string>& VerdictNames();        // Verdict
std::string VerdictName(Verdict verdict);

}  // namespace mlic
