#pragma once

#include <optional>
#include <string>

#include "mlic_core/io/yaml_reader.h"
#include "mlic_core/result/run_record.h"

namespace mlic {

// `run` of calibration.yaml (docs/outputs.md), with its key; empty where there is none.
std::string RunText(const std::optional<RunRecord>& run);

// root: of the file.
std::optional<RunRecord> ReadRun(const YamlReader& root);

}  // namespace mlic
