#pragma once

#include <optional>
#include <string>
#include <vector>

#include "mlic_core/result/result.h"

namespace mlic {

// How far the pixels of one camera are from where the true intrinsics put what they see. Over a grid of the
// whole image; pixels that either model does not cover are left out.
struct IntrinsicsError {
  std::string name;
  double covered = 0.0;  // share of the grid that took part
  double mean = 0.0;     // px
  double largest = 0.0;  // px
  // The same once a small rotation of the camera has taken up what it can: what remains no extrinsic mends.
  double mean_after_rotation = 0.0;
  std::optional<double> readout;  // s, estimate minus truth, of rolling shutters
};

// For every camera that has intrinsics in both; the models may differ.
std::vector<IntrinsicsError> CompareIntrinsics(const CalibrationResult& result,
                                               const CalibrationResult& truth);

// For people; empty when there are no cameras.
std::string TableOf(const std::vector<IntrinsicsError>& errors);

// name,covered,mean_px,largest_px,mean_after_rotation_px,readout
std::string CsvOf(const std::vector<IntrinsicsError>& errors);

}  // namespace mlic
