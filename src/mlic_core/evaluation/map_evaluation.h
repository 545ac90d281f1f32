#pragma once

#include <string>
#include <vector>

#include "mlic_core/evaluation/map_quality.h"

namespace mlic {

// The figures of merit of a map under a calibration, for `evaluate`.
struct MapEvaluation {
  MapEntropy all;                     // of all points together
  std::vector<MapEntropy> of_sensor;  // of each sensor alone; no queries used where it has no points
  std::vector<OverlapThickness> overlaps;
};

// points: of BuildMap or CalibrationResult::map. Planes are found anew in voxels of 0.5 m when no point has
// one.
MapEvaluation EvaluateMap(std::vector<MapPoint> points, const CalibrationResult& calibration);

// For people, one figure a line: entropies in nats, thicknesses in millimetres.
std::string TableOf(const MapEvaluation& evaluation, const CalibrationResult& calibration);

// kind,name,value: map_entropy of "all" and of each sensor, overlap_thickness and overlap_separation of each
// pair, m.
std::string CsvOf(const MapEvaluation& evaluation, const CalibrationResult& calibration);

}  // namespace mlic
