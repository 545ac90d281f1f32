#pragma once

#include <string>
#include <vector>

#include "mlic_core/io/yaml_reader.h"
#include "mlic_core/result/sigma_in_use.h"

namespace mlic {

// What `use` of a sensor or a pair holds in calibration.yaml (docs/outputs.md), in one line.
std::string InUseText(const std::vector<SigmaInUse>& uses);

// Of a sensor or a pair; empty where it has no `use`, as of earlier versions.
std::vector<SigmaInUse> ReadInUse(const YamlReader& owner);

}  // namespace mlic
