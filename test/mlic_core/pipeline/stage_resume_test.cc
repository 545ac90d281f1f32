#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>

#include "mlic_core/io/checkpoint/serialize_stages.h"
#include "mlic_core/io/checkpoint/stage_files.h"
#include "mlic_core/io/result/result_file.h"
#include "mlic_core/io/text_file.h"
#include "mlic_core/pipeline/calibrator.h"
#include "support/files.h"
#include "support/interruption.h"
#include "support/simulated_input.h"

namespace mlic::stage_resume_test {
namespace {

const SimulatedInput& TwoLidars() {
  static const SimulatedInput input = SimulateInput(ConfiguredSensors("dual_rosette.yaml"),
                                                    DriveOptions(sim::Scenario::kHandheld, 8.0, 5), false);
  return input;
}

class StageResume : public testing::Test {
 protected:
  StageFiles Files(const std::string& key = "inputs") {
    return StageFiles(directory_.Path(), key, [this](const std::string& line) { lines_.push_back(line); });
  }

  // calibration.yaml of the run, or nothing when it was interrupted.
  std::string Run(StageStore* store, const std::string& stage = "", int round = -1) {
    CancellationToken token;
    Interruption interruption(stage, round, &token);
    std::string yaml;
    try {
      const CalibrationResult result =
          Calibrate(TwoLidars().rig, TwoLidars().dataset, token, interruption, store);
      const auto path = directory_.Path() / "calibration.yaml";
      WriteCalibrationFile(path, result);
      yaml = ReadFile(path);
    } catch (const Cancelled&) {
    }
    odometry_steps_ = interruption.Steps("LiDAR odometry");
    joint_rounds_ = interruption.Rounds("joint adjustment");
    return yaml;
  }

  const std::string& Uninterrupted() {
    static const std::string yaml = Run(nullptr);
    return yaml;
  }

  TemporaryDirectory directory_;
  std::vector<std::string> lines_;
  int odometry_steps_ = 0, joint_rounds_ = 0;
};

TEST_F(StageResume, ARunInterruptedAnywhereGoesOnToTheSameBytes) {
  const std::string& expected = Uninterrupted();
  ASSERT_FALSE(expected.empty());
  const int all_rounds = joint_rounds_;
  ASSERT_GT(all_rounds, 3);
  EXPECT_GT(odometry_steps_, 0);
  StageFiles files = Files();
  EXPECT_EQ(Run(&files, "initialisation"), "");
  EXPECT_GT(odometry_steps_, 0);
  for (const char* stage : {"plane adjustment of each LiDAR", "joint adjustment"}) {
    EXPECT_EQ(Run(&files, stage), "") << stage;
    EXPECT_EQ(odometry_steps_, 0) << stage;
  }
  EXPECT_EQ(Run(&files, "joint adjustment", 2), "");
  EXPECT_EQ(Run(&files), expected);
  EXPECT_EQ(odometry_steps_, 0);
  EXPECT_EQ(joint_rounds_, all_rounds - 3);
  EXPECT_TRUE(lines_.empty()) << lines_.front();
  // Once more from the last round.
  EXPECT_EQ(Run(&files), expected);
  EXPECT_EQ(joint_rounds_, 1);
}

TEST_F(StageResume, ForeignAndDamagedStagesAreSaidAndDoneAgain) {
  StageFiles files = Files();
  EXPECT_EQ(Run(&files, "plane adjustment of each LiDAR"), "");
  StageFiles other = Files("other inputs");
  DriveOdometry odometry;
  EXPECT_FALSE(other.Load("odometry_1", &odometry));
  ASSERT_EQ(lines_.size(), 1u);
  EXPECT_NE(lines_[0].find("odometry_1"), std::string::npos);

  std::string bytes = ReadFile(directory_.Path() / "odometry_1.stage");
  bytes[bytes.size() / 2] ^= 1;
  WriteFileAtomically(directory_.Path() / "odometry_1.stage", bytes);
  EXPECT_EQ(Run(&files, "initialisation"), "");
  EXPECT_GT(odometry_steps_, 0);
  EXPECT_EQ(lines_.size(), 2u);
  EXPECT_FALSE(files.Load("never_saved", &odometry));
  EXPECT_EQ(lines_.size(), 2u);
}

TEST_F(StageResume, AStageThatCannotBeKeptDoesNotStopTheRun) {
  WriteFileAtomically(directory_.Path() / "file", "");
  StageFiles files(directory_.Path() / "file" / "stages", "key",
                   [this](const std::string& line) { lines_.push_back(line); });
  files.Save("initialisation", Initialization());
  ASSERT_EQ(lines_.size(), 1u);
  EXPECT_NE(lines_[0].find("cannot be kept"), std::string::npos);
}

TEST(SerializeStages, CutAndContradictingBytesAreNoStage) {
  Adjustment adjustment;
  adjustment.state.drives.resize(2);
  for (DriveState& drive : adjustment.state.drives) {
    const UniformKnots knots{0.0, 0.1, 5};
    drive.trajectory.rotation =
        So3Spline(knots, std::vector<Eigen::Quaterniond>(5, Eigen::Quaterniond::Identity()));
    drive.trajectory.position = PositionSpline(knots, std::vector<Eigen::Vector3d>(5, {1.0, 2.0, 3.0}));
  }
  adjustment.state.cameras.resize(1);
  adjustment.state.cameras[0].intrinsics.parameters = {1.0, 2.0};
  adjustment.state.cameras[0].readout = 0.02;
  adjustment.plane_noise.resize(3);
  adjustment.rounds.done = 4;
  const std::vector<char> bytes = ToBytes(adjustment);
  Adjustment copy;
  ASSERT_TRUE(FromBytes(bytes, &copy));
  EXPECT_EQ(ToBytes(copy), bytes);
  EXPECT_EQ(copy.state.drives[1].trajectory.Pose(0.1).translation, Eigen::Vector3d(1.0, 2.0, 3.0));
  EXPECT_EQ(copy.state.cameras[0].readout, 0.02);
  EXPECT_EQ(copy.rounds.done, 4);
  for (std::size_t size = 0; size < bytes.size(); size += 7) {
    EXPECT_FALSE(FromBytes(
        std::vector<char>(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)), &copy));
  }
  // A number of knots that is not that of the control points: every int of 5 is changed in turn.
  int refused = 0;
  for (std::size_t at = 0; at + 4 <= bytes.size(); ++at) {
    std::int32_t value = 0;
    std::memcpy(&value, bytes.data() + at, 4);
    if (value != 5) continue;
    std::vector<char> bad = bytes;
    bad[at] = 6;
    if (!FromBytes(bad, &copy)) ++refused;
  }
  EXPECT_GE(refused, 1);
}

}  // namespace
}  // namespace mlic::stage_resume_test
