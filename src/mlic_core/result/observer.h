#pragma once

#include <optional>
#include <string>
#include <vector>

#include "mlic_core/common/progress.h"
#include "mlic_core/result/result.h"

namespace mlic {

// A plane of the current map, for display.
struct PlanePatch {
  Eigen::Vector3d center;  // map frame, m
  Eigen::Vector3d normal;  // unit
  Eigen::Vector3d axis_u;  // in-plane principal directions, scaled to one standard deviation, m
  Eigen::Vector3d axis_v;
};

// A point landmark, for display.
struct LandmarkMark {
  Eigen::Vector3f position;  // map frame, m
  float error = 0.0f;        // px, rms of the lengths of its reprojection errors
  int observations = 0;
};

// The state of the calibration between two solves, as much of it as there is to show.
struct CalibrationSnapshot {
  std::string stage;
  int iteration = 0;
  bool after_solve = true;                // false: cameras have just been found, and all else is as it was
  double cost = 0.0;                      // sum of squared whitened residuals, after the solve
  std::optional<double> mean_square;      // of these residuals; none before the first solve
  std::optional<double> change;           // largest of a sensor in this round, in its sigmas
  std::vector<std::string> sensor_names;  // LiDARs, then cameras
  std::vector<std::string> sensor_frames;
  std::vector<SensorCalibration> sensors;
  std::vector<CameraIntrinsics> intrinsics;  // of the cameras, the last ones of the sensors
  std::vector<PoseSigma> sigmas;             // empty until there are any
  std::vector<StampedPose> trajectory;       // T_map_imu of the first drive
  std::vector<MapPoint> points;              // a thinned-out map of the first drive
  std::vector<PlanePatch> planes;
  std::vector<LandmarkMark> landmarks;     // thinned out, of the first drive
  std::vector<CameraView> views;           // one image of each camera that sees landmarks, of the first drive
  std::vector<RigidTransform> view_poses;  // T_map_camera of each view, in the middle of its exposure
};

// Observers (RViz, log, progress bar) look and never touch. Calls come from the thread that runs the
// calibration.
class CalibrationObserver : public ProgressSink {
 public:
  void OnProgress(const std::string& /*stage*/, double /*fraction*/) override {}
  virtual void OnSnapshot(const CalibrationSnapshot& /*snapshot*/) {}
  // One line of the log.
  virtual void OnMessage(const std::string& /*line*/) {}
};

}  // namespace mlic
