#include "mlic_core/evaluation/intrinsics_error.h"

#include <algorithm>
#include <cstdio>

#include "mlic_core/geometry/so3.h"
#include "mlic_core/geometry/symmetric_matrix.h"
#include "mlic_core/sensors/camera_model.h"

namespace mlic {
namespace {

constexpr int kColumns = 40, kRows = 30;  // from: structural, a grid that is dense against distortion

IntrinsicsError Compare(const std::string& name, const CameraIntrinsics& estimate,
                        const CameraIntrinsics& truth) {
  IntrinsicsError error;
  error.name = name;
  std::vector<Eigen::Vector2d> displacements;
  std::vector<Eigen::Matrix<double, 2, 3>> of_rotation;
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      const Eigen::Vector2d pixel((estimate.width - 1.0) * column / (kColumns - 1),
                                  (estimate.height - 1.0) * row / (kRows - 1));
      Eigen::Vector3d bearing;
      Eigen::Vector2d true_pixel;
      CameraPointJacobian J_point;
      if (!Unproject(estimate, pixel, &bearing) || !Project(truth, bearing, &true_pixel, &J_point)) continue;
      const Eigen::Vector2d displacement = true_pixel - pixel;
      const Eigen::Matrix<double, 2, 3> J_rotation = -J_point * Hat(bearing);  // bearing turned on the left
      displacements.push_back(displacement);
      of_rotation.push_back(J_rotation);
      information += J_rotation.transpose() * J_rotation;
      gradient += J_rotation.transpose() * displacement;
    }
  }
  error.covered = static_cast<double>(displacements.size()) / (kColumns * kRows);
  if (displacements.size() < 10) return error;
  const Eigen::Vector3d rotation = -SolveSymmetric3(information, gradient);
  const double count = static_cast<double>(displacements.size());
  for (std::size_t i = 0; i < displacements.size(); ++i) {
    const double size = displacements[i].norm();
    error.mean += size / count;
    error.largest = std::max(error.largest, size);
    error.mean_after_rotation += (displacements[i] + of_rotation[i] * rotation).norm() / count;
  }
  return error;
}

}  // namespace

std::vector<IntrinsicsError> CompareIntrinsics(const CalibrationResult& result,
                                               const CalibrationResult& truth) {
  std::vector<IntrinsicsError> errors;
  for (const SensorResult& sensor : result.sensors) {
    const auto found = std::find_if(truth.sensors.begin(), truth.sensors.end(),
                                    [&](const SensorResult& s) { return s.name == sensor.name; });
    if (found == truth.sensors.end() || !sensor.intrinsics || !found->intrinsics) continue;
    IntrinsicsError error = Compare(sensor.name, *sensor.intrinsics, *found->intrinsics);
    if (sensor.rolling_shutter_readout && found->rolling_shutter_readout) {
      error.readout = *sensor.rolling_shutter_readout - *found->rolling_shutter_readout;
    }
    errors.push_back(error);
  }
  return errors;
}

std::string TableOf(const std::vector<IntrinsicsError>& errors) {
  std::string table;
  char line[240];
  for (const IntrinsicsError& error : errors) {
    std::snprintf(line, sizeof(line),
                  "%s: pixels off by %.3f px in the mean, %.3f px at most; %.3f px after a small rotation",
                  error.name.c_str(), error.mean, error.largest, error.mean_after_rotation);
    table += line;
    std::snprintf(line, sizeof(line), " (%.0f %% of the image)", 100.0 * error.covered);
    table += line;
    if (error.readout) {
      std::snprintf(line, sizeof(line), "; readout off by %.4f ms", 1e3 * *error.readout);
      table += line;
    }
    table += "\n";
  }
  return table;
}

std::string CsvOf(const std::vector<IntrinsicsError>& errors) {
  std::string csv = "name,covered,mean_px,largest_px,mean_after_rotation_px,readout\n";
  char line[240];
  for (const IntrinsicsError& error : errors) {
    std::snprintf(line, sizeof(line), ",%.6f,%.6f,%.6f,%.6f,", error.covered, error.mean, error.largest,
                  error.mean_after_rotation);
    csv += error.name + line;
    if (error.readout) {
      std::snprintf(line, sizeof(line), "%.9f", *error.readout);
      csv += line;
    }
    csv += "\n";
  }
  return csv;
}

}  // namespace mlic
