#pragma once

#include <vector>

#include "mlic_core/camera/tracks/tracks.h"
#include "mlic_core/imu/excitation.h"
#include "mlic_core/imu/gyro_integration.h"
#include "mlic_core/problem/state.h"
#include "mlic_core/sensors/measurements.h"

namespace mlic {

// What is known before positions are: rotations from the gyroscope, in a frame that it draws along with its
// drift, one for each drive ("gyro frame"), and the cameras' rotations, offsets and rough intrinsics.
struct KnownRotations {
  const Dataset* dataset = nullptr;
  const std::vector<TrackSet>* tracks = nullptr;  // of each drive
  std::vector<GyroIntegration> gyro;              // of each drive, bias taken out
  std::vector<ImuSigma> imu_sigma;                // of each drive
  std::vector<double> knot_spacing;               // s, of each drive's positions
  std::vector<CameraCalibration> cameras;         // their translations are not used
  std::vector<bool> found;                        // cameras that take part
  std::vector<ExtrinsicGuess> guesses;            // of each camera: only translations and their sigmas
  double least_sigma = 8.0;                       // px; covers what the intrinsics are still off by
};

}  // namespace mlic
