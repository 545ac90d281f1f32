#pragma once

#include <string>
#include <vector>

#include "mlic_core/common/progress.h"
#include "mlic_core/problem/observations.h"
#include "mlic_core/result/result.h"
#include "mlic_core/sensors/measurements.h"
#include "mlic_core/sensors/rig.h"

namespace mlic {

// Places of the LiDAR map that were found in photos: each is a point of a LiDAR, in its frame and at its
// time, and the pixel of a camera that shows it. Indices of sensors are places in these names.
struct MapSightings {
  std::vector<std::string> lidars, cameras;
  LandmarkSet matches;
};

// Of the first drive, in up to 20 photos of each camera that are not among the keyframes. The map is rendered
// and sought as in the calibration (docs/method.md, section 9), within 0.3 deg and 3 cm whatever that claims:
// wide enough not to hide its errors. Matches of a camera have to agree with one pose of it, found from
// themselves. Sensors that the calibration lacks are left out.
MapSightings FindMapSightings(const Rig& rig, const Dataset& dataset, const CalibrationResult& calibration,
                              const std::vector<StampedPose>& trajectory,
                              const std::vector<CameraKeyframes>& keyframes,
                              const CancellationToken& cancellation);

// How far points of a LiDAR are from where a camera sees them.
struct ReprojectionStatistics {
  std::string lidar;  // empty: of all LiDARs together
  std::string camera;
  std::size_t matches = 0;
  double median = 0.0;  // px, of the lengths
  double rms = 0.0;     // px
};

// Under a calibration, on the trajectory (T_map_imu, IMU clock; epoch: of the drive). For each camera first
// of all LiDARs together, then of each; pairs with fewer than 30 matches are not listed.
std::vector<ReprojectionStatistics> MeasureReprojection(const MapSightings& sightings,
                                                        const CalibrationResult& calibration,
                                                        const std::vector<StampedPose>& trajectory,
                                                        TimeNs epoch);

// The errors under one calibration.
struct ReprojectionColumn {
  std::string name;  // "calibration", "truth", ...
  std::vector<ReprojectionStatistics> errors;
};

// For people: one line for each camera and pair, medians (px) side by side.
std::string TableOf(const std::vector<ReprojectionColumn>& columns);

// calibration,lidar,camera,matches,median_px,rms_px; lidar "all" for all together.
std::string CsvOf(const std::vector<ReprojectionColumn>& columns);

}  // namespace mlic
