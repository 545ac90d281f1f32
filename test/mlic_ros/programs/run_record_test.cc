#include "mlic_ros/programs/run_record.h"

#include <gtest/gtest.h>

#include "mlic_core/common/error.h"
#include "mlic_core/io/text_file.h"
#include "support/files.h"

namespace mlic::run_record_test {
namespace {

namespace fs = std::filesystem;

class RunRecordTest : public ::testing::Test {
 protected:
  RunRecordTest() {
    WriteFileAtomically(In("rig.yaml"),
                        "imu: {topic: /imu}\ncameras:\n  one: {topic: /one, fov_deg: 90, mask: mask.png}\n");
    WriteFileAtomically(In("mask.png"), "mask");
    WriteFileAtomically(In("a drive.bag"), std::string(3000000, 'a'));
    options_.rig = In("rig.yaml");
    options_.bags = {In("a drive.bag")};
  }
  fs::path In(const std::string& name) const { return directory_.Path() / name; }

  TemporaryDirectory directory_;
  JobOptions options_;
};

TEST_F(RunRecordTest, HasEveryFileAndTheCommand) {
  const std::string folder = directory_.Path().string();
  RunRecord run = RecordRun(options_);
  EXPECT_FALSE(run.version.empty());
  EXPECT_EQ(run.command,
            "rosrun mlic calibrate --rig " + folder + "/rig.yaml --bag '" + folder + "/a drive.bag'");
  ASSERT_EQ(run.inputs.size(), 3u);
  EXPECT_EQ(run.inputs[1].path, folder + "/mask.png");
  EXPECT_EQ(run.inputs[2].path, folder + "/a drive.bag");
  EXPECT_EQ(run.inputs[2].hash.size(), 16u);
  EXPECT_EQ(run.options[1], (std::pair<std::string, std::string>("duration", "0")));

  WriteFileAtomically(In("prior.yaml"), "x");
  options_.prior = In("prior.yaml");
  options_.added = {"one"};
  options_.load.start = 2.5;
  options_.load.duration = 30.0;
  options_.calibration.intrinsics = IntrinsicsStart::kColmap;
  run = RecordRun(options_);
  EXPECT_EQ(run.inputs.size(), 4u);
  EXPECT_TRUE(Contains(run.command, "/prior.yaml --add one --bag "));
  EXPECT_TRUE(Contains(run.command, " --start 2.5 --duration 30 --intrinsics colmap"));
  options_.bags.push_back(In("none.bag"));
  EXPECT_TRUE(Contains(InputErrorOf([&] { RecordRun(options_); }), "none.bag: no such file"));
}

TEST_F(RunRecordTest, ARecordingIsKnownByItsContent) {
  const RunRecord earlier = RecordRun(options_);
  fs::copy_file(In("a drive.bag"), In("copy.bag"));
  fs::last_write_time(In("copy.bag"), fs::file_time_type::clock::now() + std::chrono::hours(1));
  WriteFileAtomically(In("other.bag"), std::string(3000000, 'b'));
  options_.bags = {In("copy.bag"), In("other.bag")};
  // The rig file is the same, too, and may be.
  EXPECT_EQ(SharedInputs(RecordRun(options_), earlier, options_.bags),
            (std::vector<std::string>{In("copy.bag").string()}));
  EXPECT_TRUE(SharedInputs(RecordRun(options_), RunRecord(), options_.bags).empty());
}

}  // namespace
}  // namespace mlic::run_record_test
