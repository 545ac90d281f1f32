#pragma once

#include <string>
#include <vector>

#include "mlic_core/evaluation/map_quality.h"
#include "mlic_core/sensors/measurements.h"

namespace mlic {

// The mean entropy of one LiDAR's own map, its rotation to the IMU turned by an angle: of the six maps turned
// to either side about each of the IMU's axes the mean, and the crispest.
struct TurnedEntropy {
  std::string lidar;
  double degrees = 0.0;
  double mean = 0.0, least = 0.0;  // nats
};

// How sharply each LiDAR's map tells its rotation: as calibrated (0 deg) and turned by 0.1 and 0.5 deg.
// trajectory, stride: as of BuildMap. LiDARs whose map is empty are left out.
std::vector<TurnedEntropy> EntropyOfTurnedLidars(const Drive& drive, const std::vector<std::string>& names,
                                                 const std::vector<StampedPose>& trajectory,
                                                 const CalibrationResult& calibration, std::size_t stride);

std::string TableOf(const std::vector<TurnedEntropy>& entropies);

// lidar,degrees,mean,least
std::string CsvOf(const std::vector<TurnedEntropy>& entropies);

}  // namespace mlic
