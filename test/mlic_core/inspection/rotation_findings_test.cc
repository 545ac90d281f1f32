#include "mlic_core/inspection/rotation_findings.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mlic_core/geometry/so3.h"
#include "mlic_core/inspection/find_finding.h"

namespace mlic::rotation_findings_test {
namespace {

// A LiDAR that the gyroscope shows at `truth`, with a guess; shown: how many directions.
LidarRotation Measured(const std::string& name, const Eigen::Quaterniond& truth,
                       const Eigen::Quaterniond& guess, int shown = 3) {
  LidarRotation lidar;
  lidar.name = name;
  lidar.guess.emplace();
  lidar.guess->T_imu_sensor.rotation = guess;
  lidar.alignment.valid = true;
  lidar.alignment.R_imu_lidar = truth;
  lidar.alignment.time_offset_sigma = 1e-3;
  lidar.alignment.inlier_share = 0.9;
  lidar.alignment.rotation_directions_shown = shown;
  for (int i = 0; i < 3; ++i) lidar.alignment.information_values[i] = i < 3 - shown ? 0.0 : 1e6;
  // The least shown is about z.
  lidar.alignment.information_directions.col(0) = Eigen::Vector3d::UnitZ();
  lidar.alignment.information_directions.col(2) = Eigen::Vector3d::UnitX();
  return lidar;
}

const Eigen::Quaterniond kFront = FromRollPitchYaw({1.7, 1.5, 0.2}),
                         kBack = FromRollPitchYaw({-1.2, 0.3, 2.5});

std::string RemedyOf(const std::vector<LidarRotation>& lidars) {
  return FindingOf(RotationFindings(lidars), "rotation to the IMU").remedy;
}

TEST(RotationFindings, PassGoodGuesses) {
  const Eigen::Quaterniond off = ExpQuaternion(Eigen::Vector3d(0.08, -0.1, 0.05));
  const std::vector<LidarRotation> lidars{Measured("front", kFront, off * kFront),
                                          Measured("back", kBack, off * kBack)};
  for (const Finding& finding : RotationFindings(lidars))
    EXPECT_EQ(finding.grade, Grade::kPass) << FindingLine(finding);
}

TEST(RotationFindings, NameExchangedTopics) {
  const std::vector<LidarRotation> lidars{Measured("front", kBack, kFront), Measured("back", kFront, kBack)};
  EXPECT_NE(RemedyOf(lidars).find("front and back look exchanged"), std::string::npos) << RemedyOf(lidars);
}

TEST(RotationFindings, NameAnInvertedGuess) {
  const std::vector<LidarRotation> lidars{Measured("front", kFront, kFront.conjugate()),
                                          Measured("back", kBack, kBack)};
  EXPECT_NE(RemedyOf(lidars).find("inverted"), std::string::npos) << RemedyOf(lidars);
}

TEST(RotationFindings, WhatIsNotShownContradictsNothing) {
  const Eigen::Quaterniond turned = ExpQuaternion(Eigen::Vector3d(0.0, 0.0, 2.0)) * kFront;
  EXPECT_EQ(FindingOf(RotationFindings({Measured("front", turned, kFront, 2)}), "rotation to the IMU").grade,
            Grade::kPass);
  LidarRotation lost = Measured("front", kFront, kFront);
  lost.alignment.time_offset_sigma = 10.0;
  EXPECT_EQ(FindingOf(RotationFindings({lost}), "odometry beside the gyroscope").grade, Grade::kWarn);
  EXPECT_EQ(FindingOf(RotationFindings({lost}), "rotation to the IMU").check, "absent");
}

TEST(FrameFindings, NameSensorsThatCarryEachOthersFrames) {
  EXPECT_TRUE(FrameFindings({{"left", "left_frame", "left_frame"}, {"right", "", "any"}}).empty());
  EXPECT_TRUE(FrameFindings({{"left", "mine", "driver"}, {"right", "other", "driver"}}).empty());
  const Findings findings = FrameFindings({{"left", "l", "r"}, {"right", "r", "l"}});
  ASSERT_EQ(findings.size(), 2u);
  EXPECT_NE(findings[0].remedy.find("left and right look exchanged"), std::string::npos);
}

TEST(LiveliestStretch, IsWhereItTurnsAboutTwoAxes) {
  std::vector<ImuSample> imu;
  for (int i = 0; i < 6000; ++i) {
    const double t = 0.01 * i;
    const double other = t > 30.0 && t < 42.0 ? 0.5 * std::sin(2.0 * t) : 0.0;
    imu.push_back({t, {other, 0.001 * std::sin(t), 0.8 * std::sin(t)}, {0.0, 0.0, 9.81}});
  }
  EXPECT_NEAR(LiveliestStretch(imu, 12.0).start, 30.0, 2.1);
  EXPECT_NEAR(LiveliestStretch(imu, 100.0).end, 59.99, 0.1);
}

}  // namespace
}  // namespace mlic::rotation_findings_test
