#include "mlic_core/inspection/cost.h"

#include <gtest/gtest.h>

namespace mlic {
namespace {

// Rows of docs/benchmark.md.
TEST(Cost, IsThatOfTheBenchmarks) {
  struct Row {
    std::size_t scans, cameras;
    double seconds, memory;
  };
  for (const Row& row : {Row{300, 0, 17.0, 0.48}, Row{1200, 0, 57.0, 0.81}, Row{2400, 0, 99.0, 1.45},
                         Row{4800, 0, 208.0, 2.46}, Row{2400, 6, 630.0, 2.9}}) {
    const Cost cost = ExpectedCost(row.scans, row.cameras);
    EXPECT_NEAR(cost.processor_seconds / row.seconds, 1.0, 0.25) << row.scans;
    EXPECT_NEAR(cost.memory / row.memory, 1.0, 0.25) << row.scans;
  }
}

TEST(Cost, IsComparedWithTheMachine) {
  const Cost cost = ExpectedCost(4800, 0);
  EXPECT_EQ(CostFindings(cost, 16.0, 4).at(0).grade, Grade::kPass);
  EXPECT_EQ(CostFindings(cost, 3.0, 4).at(0).grade, Grade::kWarn);
  EXPECT_EQ(CostFindings(cost, 2.0, 4).at(0).grade, Grade::kFail);
}

}  // namespace
}  // namespace mlic
