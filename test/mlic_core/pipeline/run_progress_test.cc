#include "mlic_core/pipeline/run_progress.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace mlic::run_progress_test {
namespace {

RunProgress ThreeStages() { return RunProgress({{"loading", 1.0}, {"odometry", 3.0}, {"adjustment", 6.0}}); }

TEST(RunProgress, KnowsNothingBeforeTheFirstStage) {
  RunProgress progress = ThreeStages();
  EXPECT_EQ(progress.StageNumber(), 0);
  EXPECT_EQ(progress.StageCount(), 3);
  EXPECT_EQ(progress.Done(5.0), 0.0);
  EXPECT_FALSE(progress.SecondsLeft(5.0));
}

TEST(RunProgress, PredictsByThePaceOfWhatIsDone) {
  RunProgress progress = ThreeStages();
  progress.Report("loading", 0.0, 0.0);
  progress.Report("odometry", 0.0, 10.0);  // a share of one takes 10 s
  EXPECT_EQ(progress.StageNumber(), 2);
  ASSERT_TRUE(progress.SecondsLeft(10.0));
  EXPECT_NEAR(*progress.SecondsLeft(10.0), 90.0, 1e-9);
  progress.Report("odometry", 0.5, 40.0);  // it is slower: 1 + 1.5 shares in 40 s
  EXPECT_NEAR(progress.Done(40.0), 2.5 / 10.0, 1e-9);
  EXPECT_NEAR(*progress.SecondsLeft(40.0), 40.0 / 2.5 * 7.5, 1e-9);
}

TEST(RunProgress, ASilentStageGoesOnByItsExpectedTimeButNotToItsEnd) {
  RunProgress progress = ThreeStages();
  progress.Report("loading", 0.0, 0.0);
  progress.Report("odometry", 0.0, 10.0);
  EXPECT_NEAR(progress.Done(25.0), (1.0 + 1.5) / 10.0, 1e-9);
  EXPECT_NEAR(progress.Done(1000.0), (1.0 + 0.9 * 3.0) / 10.0, 1e-9);
  EXPECT_NEAR(*progress.SecondsLeft(1000.0), 63.0, 1e-9);
}

TEST(RunProgress, StagesThatAnEarlierRunLeftSayNothingOfThePace) {
  RunProgress progress = ThreeStages();
  progress.Report("loading", 0.0, 0.0);
  progress.Report("odometry", 0.0, 10.0);
  progress.Report("adjustment", 0.0, 10.1);
  EXPECT_NEAR(progress.Done(10.1), 0.4, 1e-9);
  EXPECT_NEAR(*progress.SecondsLeft(10.1), 60.0, 1e-9);
}

TEST(RunProgress, PartsAndStagesOffThePlanBelongToThePresentStage) {
  RunProgress progress = ThreeStages();
  progress.Report("loading", 0.0, 0.0);
  progress.Report("odometry", 0.25, 10.0);
  progress.Report("odometry", 0.25, 10.0);
  progress.Report("odometry (second pass)", 0.9, 10.0);
  progress.Report("intrinsics by COLMAP", 0.9, 10.0);
  progress.Report("loading", 0.9, 10.0);
  EXPECT_EQ(progress.StageNumber(), 2);
  EXPECT_NEAR(progress.Done(10.0), (1.0 + 0.75) / 10.0, 1e-9);
}

TEST(RunProgress, NeverFalls) {
  RunProgress progress = ThreeStages();
  progress.Report("loading", 0.0, 0.0);
  progress.Report("odometry", 0.0, 2.0);
  const double before = progress.Done(30.0);
  progress.Report("odometry", 0.1, 31.0);  // far slower than thought
  EXPECT_GE(progress.Done(31.0), before);
}

TEST(RunPlan, HasTheStagesOfTheRig) {
  const auto has = [](const Rig& rig, const std::string& name) {
    const std::vector<PlannedStage> plan = PlanRun(rig, {});
    EXPECT_TRUE(std::all_of(plan.begin(), plan.end(), [](const auto& stage) { return stage.share > 0.0; }));
    return std::any_of(plan.begin(), plan.end(), [&](const auto& stage) { return stage.name == name; });
  };
  Rig rig;
  rig.lidars.resize(1);
  EXPECT_TRUE(has(rig, "LiDAR odometry"));
  EXPECT_FALSE(has(rig, "plane adjustment of each LiDAR"));
  EXPECT_FALSE(has(rig, "image features"));
  rig.lidars.resize(2);
  EXPECT_TRUE(has(rig, "plane adjustment of each LiDAR"));
  rig.cameras.resize(1);
  EXPECT_TRUE(has(rig, "joint calibration on the map"));
  EXPECT_FALSE(has(rig, "first tracks across cameras"));
  rig.lidars.clear();
  EXPECT_FALSE(has(rig, "joint calibration on the map"));
  EXPECT_FALSE(has(rig, "LiDAR odometry"));
}

}  // namespace
}  // namespace mlic::run_progress_test
