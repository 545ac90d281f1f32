#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "mlic_core/result/result.h"

namespace mlic {

// A sensor as the report draws it: in the frame of the IMU, or of CalibrationResult::root.
struct DrawnSensor {
  std::string name, frame;  // frame: as in the exported files
  SensorResult::Type type = SensorResult::Type::kLidar;
  std::string color;
  RigidTransform T_root_sensor;
  std::optional<RigidTransform> guess;  // T_root_sensor of the rig file
  PoseSigma sigma;                      // along and about the root's axes
  std::array<bool, 3> translation_observable{true, true, true};
  std::optional<double> time_offset;     // s, to the IMU's clock
  std::vector<Eigen::Vector3d> outline;  // of a camera: bearings along the edge of its image
};

struct RigDrawing {
  std::string root;                  // the frame
  std::vector<DrawnSensor> sensors;  // those that are given for use; without the root itself
  // Rows: forward, left and up of the vehicle in the root's frame, as the drive shows them.
  Eigen::Matrix3d R_view_root = Eigen::Matrix3d::Identity();
  double extent = 0.0;           // m, of the sensors and the root
  double ellipsoid_scale = 1.0;  // by which sigmas of translation are enlarged to be seen
};

RigDrawing DrawingOf(const CalibrationResult& result);

}  // namespace mlic
