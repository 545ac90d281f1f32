#include "mlic_core/summary/result_assembly.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "mlic_core/problem/layout.h"
#include "support/lidars_at_rest.h"

namespace mlic::result_assembly_test {
namespace {

// A camera whose time offset moves faster than clocks do.
TEST(Result, SaysOfACameraWhatMovesItsStamps) {
  Dataset dataset;
  Adjustment adjustment;
  PlaceAtRest(20, 0, &dataset, &adjustment.problem, &adjustment.state);
  CameraCalibration camera;
  camera.intrinsics = {CameraModel::kPlumbBob, 640, 480, {400.0, 400.0, 320.0, 240.0, 0, 0, 0, 0, 0}};
  camera.sensor.clock_drift = 2.5 * kFastestCrystals;
  adjustment.state.cameras = {camera};
  adjustment.initial = adjustment.state;
  adjustment.problem.cameras.resize(1);
  adjustment.cameras.found = {true};
  adjustment.cameras.landmark_options.noise.resize(1);
  adjustment.contradicted_guesses = {false};
  adjustment.halves.resize(1);
  const int calibration = Layout(adjustment.state, false).calibration;
  adjustment.last_solve.information = 1e12 * Eigen::MatrixXd::Identity(calibration, calibration);
  Rig rig;
  rig.cameras.resize(1);
  rig.cameras[0].name = "front";
  CalibrationResult result;
  AssembleResult(rig, dataset, adjustment, &result);
  ASSERT_EQ(result.sensors.size(), 1u);
  EXPECT_TRUE(std::any_of(result.warnings.begin(), result.warnings.end(), [](const std::string& warning) {
    return warning.find("front: its time offset moves by 250 us a second") != std::string::npos;
  }));
}

}  // namespace
}  // namespace mlic::result_assembly_test
