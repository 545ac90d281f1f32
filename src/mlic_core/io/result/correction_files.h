#pragma once

#include <string>
#include <vector>

#include "mlic_core/io/result/exported_file.h"
#include "mlic_core/io/yaml_reader.h"
#include "mlic_core/result/result.h"

namespace mlic {

// `corrections` of a LiDAR in calibration.yaml (docs/outputs.md).
std::string CorrectionsText(const PointCorrections& corrections);
PointCorrections ReadCorrections(const YamlReader& sensor);

// NAME.yaml for each LiDAR whose points were corrected: the same, and what drivers of spinning LiDARs call
// it.
std::vector<ExportedFile> CorrectionFiles(const CalibrationResult& result);

}  // namespace mlic
