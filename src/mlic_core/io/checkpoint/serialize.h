#pragma once

#include <vector>

#include "mlic_core/result/result.h"
#include "mlic_core/sensors/measurements.h"

namespace mlic {

// Objects as bytes for checkpoints on the same machine: native byte order, no promise between versions of the
// program (CheckpointStore's key must hold the version). Large arrays are copied whole.
std::vector<char> ToBytes(const Dataset& dataset);
std::vector<char> ToBytes(const CalibrationResult& result);

// False, with the object unspecified, when the bytes are not exactly one such object.
bool FromBytes(const std::vector<char>& bytes, Dataset* dataset);
bool FromBytes(const std::vector<char>& bytes, CalibrationResult* result);

}  // namespace mlic
