#pragma once

#include <string>

#include "mlic_core/result/result.h"

namespace mlic {

// Tables of the report, each a piece of HTML; angles in degrees, sigmas in millimetres, millidegrees,
// milliseconds.

// Extrinsics and time offsets with sigmas; what the drive did not show is marked, its directions are listed
// below.
std::string SensorTable(const CalibrationResult& result);
// Every parameter of every camera with its sigma; nothing where there are no intrinsics.
std::string CameraTable(const CalibrationResult& result);
// Of a result that has pairs.
std::string PairTable(const CalibrationResult& result);
// By how much the halves of the drive differ; nothing where they were not compared.
std::string HalvesTable(const CalibrationResult& result);
std::string ImuTable(const CalibrationResult& result);
// Each stage with its share of the time and what it found.
std::string StageTable(const CalibrationResult& result);

}  // namespace mlic
