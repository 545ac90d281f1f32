#include "mlic_core/evaluation/map_evaluation.h"

#include <algorithm>
#include <cstdio>

namespace mlic {
namespace {

constexpr double kPlaneVoxel = 0.5;  // m; from: definition of the figure of merit
// from: definition of the figure of merit.
constexpr double kPlaneThickness = 0.15;  // m: LiDARs may lie this far apart and still be compared

std::string NameOf(int sensor, const CalibrationResult& calibration) {
  const bool known = sensor >= 0 && static_cast<std::size_t>(sensor) < calibration.sensors.size();
  return known ? calibration.sensors[static_cast<std::size_t>(sensor)].name : std::to_string(sensor);
}

std::string Number(const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof(text), format, value);
  return text;
}

}  // namespace

MapEvaluation EvaluateMap(std::vector<MapPoint> points, const CalibrationResult& calibration) {
  const bool has_planes =
      std::any_of(points.begin(), points.end(), [](const MapPoint& p) { return p.plane >= 0; });
  if (!has_planes) AssignVoxelPlanes(kPlaneVoxel, kPlaneThickness, &points);
  const MapEntropyOptions options;
  MapEvaluation evaluation;
  evaluation.all = MeanMapEntropy(points, -1, options);
  for (std::size_t i = 0; i < calibration.sensors.size(); ++i) {
    evaluation.of_sensor.push_back(MeanMapEntropy(points, static_cast<int>(i), options));
  }
  evaluation.overlaps = OverlapThicknesses(points);
  return evaluation;
}

std::string TableOf(const MapEvaluation& evaluation, const CalibrationResult& calibration) {
  std::string table = "mean map entropy, all points: " + Number("%.3f", evaluation.all.mean) + "\n";
  for (std::size_t i = 0; i < evaluation.of_sensor.size(); ++i) {
    if (evaluation.of_sensor[i].queries_used == 0) continue;
    table += "mean map entropy, " + calibration.sensors[i].name + ": " +
             Number("%.3f", evaluation.of_sensor[i].mean) + "\n";
  }
  for (const OverlapThickness& overlap : evaluation.overlaps) {
    table += "overlap " + NameOf(overlap.lidar_a, calibration) + "/" + NameOf(overlap.lidar_b, calibration) +
             ": thickness " + Number("%.1f", 1e3 * overlap.thickness) + " mm, separation " +
             Number("%.1f", 1e3 * overlap.separation) + " mm, " + std::to_string(overlap.planes) +
             " planes\n";
  }
  return table;
}

std::string CsvOf(const MapEvaluation& evaluation, const CalibrationResult& calibration) {
  std::string csv = "kind,name,value\nmap_entropy,all," + Number("%.6f", evaluation.all.mean) + "\n";
  for (std::size_t i = 0; i < evaluation.of_sensor.size(); ++i) {
    if (evaluation.of_sensor[i].queries_used == 0) continue;
    csv += "map_entropy," + calibration.sensors[i].name + "," + Number("%.6f", evaluation.of_sensor[i].mean) +
           "\n";
  }
  for (const OverlapThickness& overlap : evaluation.overlaps) {
    const std::string pair =
        NameOf(overlap.lidar_a, calibration) + "/" + NameOf(overlap.lidar_b, calibration);
    csv += "overlap_thickness," + pair + "," + Number("%.6f", overlap.thickness) + "\n";
    csv += "overlap_separation," + pair + "," + Number("%.6f", overlap.separation) + "\n";
  }
  return csv;
}

}  // namespace mlic
