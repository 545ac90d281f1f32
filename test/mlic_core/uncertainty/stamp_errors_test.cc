#include "mlic_core/uncertainty/stamp_errors.h"

#include <gtest/gtest.h>

#include "mlic_core/association/plane_association.h"
#include "mlic_core/common/random.h"
#include "mlic_sim/image_stage.h"
#include "support/simulated_input.h"
#include "support/true_spline.h"

namespace mlic::stamp_errors_test {
namespace {

constexpr double kDuration = 14.0;  // s

// A hand-held drive at the truth, its map drawn; then scans get times that are off.
class StampErrorsOfADrive : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    const sim::SensorSet sensors = ConfiguredSensors("handheld.yaml");
    const sim::SimulationOptions options = DriveOptions(sim::Scenario::kHandheld, kDuration, 3);
    input_ = new SimulatedInput(SimulateInput(sensors, options, false));
    const auto trajectory =
        sim::MakeTrajectory(options.scenario, options.seed, options.duration, sensors.imu.T_body_imu);
    state_ = new CalibrationState();
    state_->lidars = {sensors.lidars[0].calibration};
    state_->drives.emplace_back();
    state_->drives[0].trajectory = TrueSpline(*trajectory, kDuration, 0.01);
    AssociationOptions association;
    association.root_voxel = 1.0;
    association.points_per_scan = 800;
    const std::vector<PlaneNoise> noise(1);
    problem_ = new JointProblem();
    problem_->dataset = &input_->dataset;
    PlaneAssociation& planes = problem_->drives.emplace_back().planes;
    planes = AssociatePlanes(input_->dataset.drives[0], *state_, 0, noise, association);
    const std::vector<PlaneNoise> measured = MeasurePlaneNoise(problem_->drives, *state_, noise);
    planes = AssociatePlanes(input_->dataset.drives[0], *state_, 0, measured, association);
  }
  static void TearDownTestSuite() {
    delete problem_;
    delete state_;
    delete input_;
  }

  // error: by how much a scan's stamp is late, s, from its number and its time.
  template <typename Error>
  StampErrors With(const Error& error) {
    JointProblem problem = *problem_;
    Dataset dataset = input_->dataset;
    problem.dataset = &dataset;
    std::vector<LidarScan>& scans = dataset.drives[0].lidars[0].scans;
    std::vector<double> true_times, late;
    for (std::size_t s = 0; s < scans.size(); ++s) {
      true_times.push_back(scans[s].time);
      late.push_back(error(s, scans[s].time));
      scans[s].time += late.back();
    }
    for (PlaneObservation& o : problem.drives[0].planes.observations) {
      const auto next = std::upper_bound(true_times.begin(), true_times.end(), o.time + 1e-6);
      o.time += late[next - true_times.begin() - 1];
    }
    return MeasureStampErrors(problem, *state_).at(0);
  }

  static SimulatedInput* input_;
  static CalibrationState* state_;
  static JointProblem* problem_;
};
SimulatedInput* StampErrorsOfADrive::input_ = nullptr;
CalibrationState* StampErrorsOfADrive::state_ = nullptr;
JointProblem* StampErrorsOfADrive::problem_ = nullptr;

TEST_F(StampErrorsOfADrive, AreNoiseWhereStampsAreRight) {
  const StampErrors errors = With([](std::size_t, double) { return 0.0; });
  EXPECT_LT(errors.excess, 2.0);
  EXPECT_FALSE(errors.wanders);
}

TEST_F(StampErrorsOfADrive, ShowHowFarStampsJitter) {
  Random random(5);
  const StampErrors errors = With([&](std::size_t, double) { return 0.002 * random.Normal(); });
  EXPECT_GT(errors.excess, 20.0);
  EXPECT_NEAR(errors.jitter, 0.002, 0.0006);
  EXPECT_FALSE(errors.wanders);
}

TEST_F(StampErrorsOfADrive, TellDriftsAndJumpsFromJitter) {
  const StampErrors jump = With([](std::size_t, double time) { return time < 7.0 ? 0.0 : 0.001; });
  EXPECT_GT(jump.excess, 20.0);
  EXPECT_TRUE(jump.wanders);
  const StampErrors drift = With([](std::size_t, double time) { return 1e-4 * (time - 7.0); });
  EXPECT_GT(drift.excess, 4.0);
  EXPECT_TRUE(drift.wanders);
}

}  // namespace
}  // namespace mlic::stamp_errors_test
