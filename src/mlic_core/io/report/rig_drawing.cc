#include "mlic_core/io/report/rig_drawing.h"

#include <algorithm>
#include <cmath>

#include "mlic_core/io/report/report_figures.h"
#include "mlic_core/io/result/sensor_tree.h"
#include "mlic_core/result/vehicle_axes.h"
#include "mlic_core/sensors/camera_model.h"

namespace mlic {
namespace {

// Constants of this file, from: structural, how the report looks.

constexpr double kLeastExtent = 0.2;     // m
constexpr double kEllipsoidShare = 0.1;  // of the extent: the semi-axis of the largest sigma
constexpr int kEdgeSteps = 8;            // along each edge of an image

// Of one sensor of the result; null where it is only in pairs.
const SensorResult* FindSensor(const CalibrationResult& result, const std::string& name) {
  for (const SensorResult& sensor : result.sensors) {
    if (sensor.name == name) return &sensor;
  }
  return nullptr;
}

std::optional<RigidTransform> GuessOf(const CalibrationResult& result, const std::string& name) {
  for (const GuessedPose& guess : result.guesses) {
    if (guess.name == name) return guess.T_imu_sensor;
  }
  return std::nullopt;
}

// T_root_sensor as the rig file has it.
std::optional<RigidTransform> GuessAboutRoot(const CalibrationResult& result, const std::string& name) {
  const std::optional<RigidTransform> guess = GuessOf(result, name);
  if (result.root.empty() || !guess) return guess;
  const std::optional<RigidTransform> root = GuessOf(result, result.root);
  if (!root) return std::nullopt;
  return root->Inverse() * *guess;
}

// Bearings along the image's edge, once around, where the model has them.
std::vector<Eigen::Vector3d> OutlineOf(const CameraIntrinsics& intrinsics) {
  const double right = intrinsics.width - 1.0, bottom = intrinsics.height - 1.0;
  const Eigen::Vector2d corners[] = {{0, 0}, {right, 0}, {right, bottom}, {0, bottom}, {0, 0}};
  std::vector<Eigen::Vector3d> outline;
  for (int edge = 0; edge < 4; ++edge) {
    for (int step = 0; step < kEdgeSteps; ++step) {
      const double share = static_cast<double>(step) / kEdgeSteps;
      Eigen::Vector3d bearing;
      if (Unproject(intrinsics, (1.0 - share) * corners[edge] + share * corners[edge + 1], &bearing)) {
        outline.push_back(bearing);
      }
    }
  }
  return outline;
}

// Of a sensor that stands in pairs alone: sigmas along the root's axes, or, where the pair is told along the
// sensor's own, the largest of them.
void TakeSigmaOfPair(const CalibrationResult& result, DrawnSensor* sensor) {
  for (const PairResult& pair : result.pairs) {
    if (pair.a == result.root && pair.b == sensor->name) sensor->sigma = pair.sigma;
    if (pair.b != result.root || pair.a != sensor->name) continue;
    sensor->sigma.translation.setConstant(pair.sigma.translation.maxCoeff());
    sensor->sigma.rotation.setConstant(pair.sigma.rotation.maxCoeff());
    sensor->sigma.time_offset = pair.sigma.time_offset;
  }
}

SensorResult::Type TypeOfRejected(const CalibrationResult& result, const std::string& name) {
  for (const RejectedSensor& rejected : result.rejected) {
    if (rejected.name == name) return rejected.type;
  }
  return SensorResult::Type::kLidar;
}

DrawnSensor Draw(const CalibrationResult& result, const TreeFrame& frame, std::size_t index) {
  DrawnSensor drawn;
  drawn.name = frame.name;
  drawn.frame = frame.frame;
  drawn.color = SensorColor(index);
  drawn.T_root_sensor = frame.T_parent_frame;
  drawn.guess = GuessAboutRoot(result, frame.name);
  drawn.time_offset = frame.time_offset;
  drawn.type = TypeOfRejected(result, frame.name);
  const SensorResult* sensor = result.root.empty() ? FindSensor(result, frame.name) : nullptr;
  if (sensor == nullptr) {
    TakeSigmaOfPair(result, &drawn);
    return drawn;
  }
  drawn.type = sensor->type;
  drawn.sigma = sensor->sigma;
  drawn.translation_observable = sensor->translation_observable;
  if (sensor->intrinsics) drawn.outline = OutlineOf(*sensor->intrinsics);
  return drawn;
}

// 1, 2 or 5 times a power of ten, such that the largest observable sigma has its share of the extent; 1 where
// none is observable.
double EllipsoidScale(const RigDrawing& drawing) {
  double largest = 0.0;
  for (const DrawnSensor& sensor : drawing.sensors) {
    for (std::size_t k = 0; k < 3; ++k) {
      if (!sensor.translation_observable[k]) continue;
      largest = std::max(largest, sensor.sigma.translation[static_cast<Eigen::Index>(k)]);
    }
  }
  if (largest == 0.0) return 1.0;
  const double wanted = kEllipsoidShare * drawing.extent / largest;
  const double power = std::pow(10.0, std::floor(std::log10(std::max(1.0, wanted))));
  for (const double factor : {5.0, 2.0}) {
    if (factor * power <= wanted) return factor * power;
  }
  return power;
}

}  // namespace

RigDrawing DrawingOf(const CalibrationResult& result) {
  const SensorTree tree = TreeOf(result);
  RigDrawing drawing;
  drawing.root = tree.parent;
  for (std::size_t i = 0; i < tree.frames.size(); ++i) {
    drawing.sensors.push_back(Draw(result, tree.frames[i], i));
  }
  Eigen::Vector3d low = Eigen::Vector3d::Zero(), high = Eigen::Vector3d::Zero();
  for (const DrawnSensor& sensor : drawing.sensors) {
    low = low.cwiseMin(sensor.T_root_sensor.translation);
    high = high.cwiseMax(sensor.T_root_sensor.translation);
  }
  drawing.extent = std::max(kLeastExtent, (high - low).norm());
  drawing.R_view_root = VehicleAxes(result);
  drawing.ellipsoid_scale = EllipsoidScale(drawing);
  return drawing;
}

}  // namespace mlic
