#include "mlic_core/summary/result_assembly.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "mlic_core/problem/layout.h"
#include "support/lidars_at_rest.h"

namespace mlic::result_assembly_test {
namespace {

// A camera, "front", beside a LiDAR at rest; all of it is known well.
struct OneCamera {
  Dataset dataset;
  Adjustment adjustment;
  Rig rig;

  OneCamera() {
    PlaceAtRest(20, 0, &dataset, &adjustment.problem, &adjustment.state);
    CameraCalibration camera;
    camera.intrinsics = {CameraModel::kPlumbBob, 640, 480, {400.0, 400.0, 320.0, 240.0, 0, 0, 0, 0, 0}};
    adjustment.state.cameras = {camera};
    adjustment.problem.cameras.resize(1);
    adjustment.cameras.found = {true};
    adjustment.cameras.landmark_options.noise.resize(1);
    adjustment.contradicted_guesses = {false};
    adjustment.halves.resize(1);
    rig.cameras.resize(1);
    rig.cameras[0].name = "front";
  }

  CalibrationResult Assembled() {
    adjustment.initial = adjustment.state;
    const int calibration = Layout(adjustment.state, false).calibration;
    adjustment.last_solve.information = 1e12 * Eigen::MatrixXd::Identity(calibration, calibration);
    CalibrationResult result;
    AssembleResult(rig, dataset, adjustment, &result);
    return result;
  }
};

// A camera whose time offset moves faster than clocks do.
TEST(Result, SaysOfACameraWhatMovesItsStamps) {
  OneCamera front;
  front.adjustment.state.cameras[0].sensor.clock_drift = 2.5 * kFastestCrystals;
  const CalibrationResult result = front.Assembled();
  ASSERT_EQ(result.sensors.size(), 1u);
  EXPECT_TRUE(std::any_of(result.warnings.begin(), result.warnings.end(), [](const std::string& warning) {
    return warning.find("front: its time offset moves by 250 us a second") != std::string::npos;
  }));
}

// A mount that came loose looks like stamps that wander; halves of wandering ones agree once they are
// followed.
TEST(Result, RejectsACameraWhoseHalvesHaveOtherOffsetsThoughItsStampsWander) {
  OneCamera front;
  StampCourse course;
  course.times = {0.0, 1.0};
  course.shifts = {-1e-3, 1e-3};
  front.adjustment.cameras.stamp_courses = {{course}};
  for (const double deviation : {2.0, 7.5}) {
    HalvesDifference offset;
    offset.quantity = HalvesDifference::Quantity::kTimeOffset;
    offset.difference = {1.5e-3};
    offset.sigma = {1.5e-3 / deviation};
    offset.deviation = offset.largest = deviation;
    offset.squares = deviation * deviation;
    offset.directions = 1;
    front.adjustment.halves[0].quantities = {offset};
    const CalibrationResult result = front.Assembled();
    const auto halves = std::find_if(result.checks.begin(), result.checks.end(),
                                     [](const QualityCheck& check) { return check.name == "halves"; });
    ASSERT_NE(halves, result.checks.end());
    EXPECT_EQ(halves->Passed(), deviation < 4.0) << halves->value << " of " << halves->limit;
  }
}

}  // namespace
}  // namespace mlic::result_assembly_test
