#include "mlic_core/evaluation/turned_entropy.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "mlic_core/evaluation/map_builder.h"
#include "mlic_core/geometry/so3.h"

namespace mlic {
namespace {

constexpr double kTurns[] = {0.0, 0.1, 0.5};  // deg; from: definition of the figure of merit

// The calibration with nothing but this LiDAR.
CalibrationResult Alone(const SensorResult& lidar) {
  CalibrationResult alone;
  alone.sensors = {lidar};
  return alone;
}

}  // namespace

std::vector<TurnedEntropy> EntropyOfTurnedLidars(const Drive& drive, const std::vector<std::string>& names,
                                                 const std::vector<StampedPose>& trajectory,
                                                 const CalibrationResult& calibration, std::size_t stride) {
  std::vector<TurnedEntropy> entropies;
  for (const SensorResult& lidar : calibration.sensors) {
    if (std::find(names.begin(), names.end(), lidar.name) == names.end()) continue;
    for (const double degrees : kTurns) {
      std::vector<double> means;
      for (int turn = 0; turn < (degrees == 0.0 ? 1 : 6); ++turn) {
        CalibrationResult turned = Alone(lidar);
        Eigen::Quaterniond& rotation = turned.sensors[0].calibration.T_imu_sensor.rotation;
        const double angle = (turn % 2 == 0 ? 1.0 : -1.0) * degrees * M_PI / 180.0;
        rotation = ExpQuaternion(angle * Eigen::Vector3d::Unit(turn / 2)) * rotation;
        const MapEntropy entropy =
            MeanMapEntropy(BuildMap(drive, names, trajectory, turned, stride), 0, MapEntropyOptions());
        if (entropy.queries_used > 0) means.push_back(entropy.mean);
      }
      if (means.empty()) continue;
      double sum = 0.0;
      for (const double mean : means) sum += mean;
      entropies.push_back({lidar.name, degrees, sum / static_cast<double>(means.size()),
                           *std::min_element(means.begin(), means.end())});
    }
  }
  return entropies;
}

std::string TableOf(const std::vector<TurnedEntropy>& entropies) {
  std::string table;
  char line[200];
  for (const TurnedEntropy& e : entropies) {
    if (e.degrees == 0.0) {
      std::snprintf(line, sizeof(line), "%s as calibrated: %.3f\n", e.lidar.c_str(), e.mean);
    } else {
      std::snprintf(line, sizeof(line), "%s turned by %.1f deg: %.3f in the mean, %.3f at its crispest\n",
                    e.lidar.c_str(), e.degrees, e.mean, e.least);
    }
    table += line;
  }
  return table;
}

std::string CsvOf(const std::vector<TurnedEntropy>& entropies) {
  std::string csv = "lidar,degrees,mean,least\n";
  char line[200];
  for (const TurnedEntropy& e : entropies) {
    std::snprintf(line, sizeof(line), "%s,%.1f,%.6f,%.6f\n", e.lidar.c_str(), e.degrees, e.mean, e.least);
    csv += line;
  }
  return csv;
}

}  // namespace mlic
