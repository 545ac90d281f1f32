#include "mlic_core/inspection/cost.h"

#include <gtest/gtest.h>

namespace mlic::cost_test {
namespace {

// Rows of docs/benchmark.md, "Long recordings".
TEST(Cost, IsThatOfTheBenchmarks) {
  struct Row {
    double scans, duration, seconds, memory;
  };
  for (const Row& row : {Row{40.0, 60.0, 265.0, 1.59}, Row{10.0, 120.0, 171.0, 1.40}}) {
    const Cost cost = ExpectedCost({row.scans, 0}, row.duration);
    EXPECT_NEAR(cost.processor_seconds / row.seconds, 1.0, 0.25) << row.duration;
    EXPECT_NEAR(cost.memory / row.memory, 1.0, 0.1) << row.duration;
  }
}

TEST(Cost, IsComparedWithTheMachine) {
  const Cost cost = ExpectedCost({40.0, 0}, 120.0);
  EXPECT_EQ(CostFindings(cost, 16.0, 4).at(0).grade, Grade::kPass);
  EXPECT_EQ(CostFindings(cost, 3.5, 4).at(0).grade, Grade::kWarn);
  EXPECT_EQ(CostFindings(cost, 2.0, 4).at(0).grade, Grade::kFail);
}

TEST(Cost, KeepsALongDriveWithinMemoryAndTime) {
  for (const SensorLoad& load :
       {SensorLoad{10.0, 0}, SensorLoad{40.0, 0}, SensorLoad{40.0, 6}, SensorLoad{0.0, 2}}) {
    const double longest = LongestDrive(load);
    const Cost cost = ExpectedCost(load, longest);
    EXPECT_GT(longest, 90.0);
    EXPECT_LT(cost.memory, load.cameras > 0 ? 6.01 : 4.01);
    EXPECT_LT(cost.processor_seconds, 1801.0);
    // Neither has much room left.
    EXPECT_TRUE(cost.memory > (load.cameras > 0 ? 5.99 : 3.99) || cost.processor_seconds > 1799.0);
  }
  // Not less than a minute, whatever the rig.
  EXPECT_EQ(LongestDrive({200.0, 40}), 60.0);
}

}  // namespace
}  // namespace mlic::cost_test
