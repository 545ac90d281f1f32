#include "mlic_core/ingest/drive_builder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "mlic_core/common/random.h"
#include "support/drive_messages.h"
#include "support/files.h"

namespace mlic::drive_builder_test {
namespace {

using Problem = ReadScan::Problem;

TEST(DriveBuilder, PutsEverythingOnOneEpoch) {
  TestMessages test;
  const Drive drive = test.Build();
  EXPECT_EQ(drive.epoch, kDriveStart);
  EXPECT_EQ(drive.imu.size(), 300u);
  ASSERT_EQ(drive.lidars.at(0).scans.size(), 30u);
  EXPECT_NEAR(drive.lidars[0].scans[7].time, 0.7, 1e-9);
  EXPECT_NEAR(drive.lidars[0].scan_period, 0.1, 1e-9);
  EXPECT_TRUE(test.notes.warnings.empty());
}

TEST(DriveBuilder, MalformedScansAreLeftOutAndCounted) {
  TestMessages test;
  for (const int bad : {0, 17})
    test.messages.lidars[0][bad] = MalformedScan(kDriveStart, "topic /points: cut off");
  EXPECT_EQ(test.Build().lidars[0].scans.size(), 28u);
  EXPECT_TRUE(IsNoted(test.notes.lines, "2 malformed (dropped)"));
  EXPECT_TRUE(IsNoted(test.notes.warnings, "2 scans are malformed"));
  for (ReadScan& scan : test.messages.lidars[0]) scan = MalformedScan(kDriveStart, "topic /points: cut off");
  EXPECT_EQ(InputErrorOf([&] { test.Build(); }), "topic /points: cut off");
}

TEST(DriveBuilder, LidarOfWhichNoScanIsLeftIsAnError) {
  TestMessages test;
  for (std::size_t i = 0; i < 30; ++i) {
    test.messages.lidars[0][i].problem = i < 5    ? Problem::kBadTimes
                                         : i < 10 ? Problem::kMalformed
                                                  : Problem::kNoReturns;
  }
  const std::string error = InputErrorOf([&] { test.Build(); });
  for (const char* part : {"topic /points: no scan can be used", "20 without returns", "5 malformed",
                           "5 with unfitting point times", "leave the LiDAR out of the rig"}) {
    EXPECT_TRUE(Contains(error, part));
  }
}

TEST(DriveBuilder, TimeRangesThatDoNotOverlapAreAnError) {
  TestMessages test;
  for (ReadScan& scan : test.messages.lidars[0]) {
    scan.stamp -= 1000'000'000'000;
    scan.start -= 1000'000'000'000;
  }
  const std::string error = InputErrorOf([&] { test.Build(); });
  for (const char* part : {"/points", "/imu", "do not overlap", "1699999000.000", "1700000000.000"}) {
    EXPECT_TRUE(Contains(error, part));
  }
}

TEST(DriveBuilder, WrongImuUnitsAreErrors) {
  const auto error = [](auto change) {
    TestMessages test;
    for (StampedImu& imu : test.messages.imu) change(imu);
    return InputErrorOf([&] { test.Build(); });
  };
  EXPECT_TRUE(Contains(error([](StampedImu& imu) { imu.specific_force.z() = 1.0; }), "looks like g"));
  EXPECT_TRUE(
      Contains(error([](StampedImu& imu) { imu.specific_force.z() = 0.05; }), "gravity had been removed"));
  EXPECT_TRUE(Contains(error([](StampedImu& imu) { imu.angular_velocity.y() = 40.0; }), "deg/s"));
}

TEST(DriveBuilder, NanImuSamplesAreDroppedAndCounted) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  TestMessages test;
  for (std::size_t i = 0; i < 300; i += 10) test.messages.imu[i].angular_velocity.x() = nan;
  EXPECT_EQ(test.Build().imu.size(), 270u);
  EXPECT_TRUE(IsNoted(test.notes.warnings, "30 IMU samples hold NaN"));
  for (StampedImu& imu : test.messages.imu) imu.specific_force.x() = nan;
  EXPECT_TRUE(Contains(InputErrorOf([&] { test.Build(); }), "all 300 IMU samples hold NaN"));
}

TEST(DriveBuilder, FrozenAndSaturatedImuReadingsAreLeftOut) {
  Random random(4);
  TestMessages test;
  std::vector<StampedImu>& imu = test.messages.imu;
  for (std::size_t i = 0; i < imu.size(); ++i) {
    imu[i].angular_velocity.x() =
        std::min(0.5, std::sin(0.05 * static_cast<double>(i)) + 0.001 * random.Normal());
    for (int axis = 0; axis < 3; ++axis) imu[i].specific_force[axis] += 0.01 * random.Normal();
    for (const int axis : {1, 2}) imu[i].angular_velocity[axis] = 0.001 * random.Normal();
    if (i < 250 || i >= 270) continue;  // a hang of 0.2 s
    imu[i].angular_velocity = imu[i - 1].angular_velocity;
    imu[i].specific_force = imu[i - 1].specific_force;
  }
  const Drive drive = test.Build();
  EXPECT_TRUE(IsNoted(test.notes.warnings, "20 IMU samples repeat the one before exactly"));
  EXPECT_TRUE(IsNoted(test.notes.warnings, "IMU samples are at the end of the sensor's range"));
  EXPECT_GT(drive.imu.size(), 160u);
  for (const ImuSample& sample : drive.imu) EXPECT_LT(sample.angular_velocity.x(), 0.5);
}

TEST(DriveBuilder, SpikesOfTheImuAreLeftOut) {
  Random random(6);
  TestMessages test;
  std::vector<StampedImu>& imu = test.messages.imu;
  for (std::size_t i = 0; i < imu.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      imu[i].angular_velocity[axis] = std::sin(0.3 * static_cast<double>(i)) + 0.002 * random.Normal();
      imu[i].specific_force[axis] += 0.3 * random.Normal();
    }
  }
  EXPECT_EQ(test.Build().imu.size(), 300u);  // fast turns are none
  for (const std::size_t i : {40, 45, 90}) imu[i].angular_velocity.y() += 20.0;
  imu[200].specific_force.z() -= 150.0;
  const Drive drive = test.Build();
  EXPECT_EQ(drive.imu.size(), 296u);
  for (const ImuSample& sample : drive.imu) {
    EXPECT_LT(sample.angular_velocity.cwiseAbs().maxCoeff(), 1.1);
    EXPECT_GT(sample.specific_force.z(), 0.0);
  }
  EXPECT_TRUE(IsNoted(test.notes.warnings, "4 IMU samples are far off both their neighbours"));
}

TEST(DriveBuilder, AnImuThatIsStampedOnArrivalStandsEvenly) {
  TestMessages test;
  Random random(11);
  test.messages.imu.clear();
  for (int k = 0; k < 600; ++k) {
    StampedImu sample;
    const double time = 0.005 * k;
    sample.stamp = kDriveStart + static_cast<TimeNs>(std::llround(1e9 * (time + 2e-3 * random.Uniform())));
    sample.record = sample.stamp;
    for (int axis = 0; axis < 3; ++axis) {
      sample.angular_velocity[axis] = std::sin((9.0 + axis) * time) + 1e-3 * random.Normal();
      sample.specific_force[axis] = 3.0 * std::cos((9.0 + axis) * time) + 1e-2 * random.Normal();
    }
    sample.specific_force.z() += 9.8;
    test.messages.imu.push_back(sample);
  }
  const std::vector<ImuSample> imu = test.Build().imu;
  EXPECT_TRUE(IsNoted(test.notes.lines, "as of arrival"));
  ASSERT_EQ(imu.size(), 600u);
  for (std::size_t k = 1; k < imu.size(); ++k) EXPECT_NEAR(imu[k].time - imu[k - 1].time, 5e-3, 1e-4);
}

TEST(DriveBuilder, AnAxisOfTheImuThatIsFrozenForMostOfTheDriveIsAnError) {
  const auto with_frozen = [](std::size_t begin, std::size_t end) {
    Random random(4);
    TestMessages test;
    for (std::size_t i = 0; i < test.messages.imu.size(); ++i) {
      StampedImu& sample = test.messages.imu[i];
      for (int axis = 0; axis < 3; ++axis) {
        sample.angular_velocity[axis] = 0.01 * random.Normal();
        sample.specific_force[axis] += 0.01 * random.Normal();
      }
      if (i >= begin && i < end) sample.angular_velocity.z() = 0.0;
    }
    return test;
  };
  TestMessages second = with_frozen(100, 200);
  EXPECT_EQ(second.Build().imu.size(), 200u);
  EXPECT_TRUE(IsNoted(second.notes.warnings, "gyroscope z repeats its reading for 100 of 300 samples"));
  TestMessages all = with_frozen(0, 300);
  EXPECT_TRUE(Contains(InputErrorOf([&] { all.Build(); }), "gyroscope z repeats its reading for 300 of 300"));
}

TEST(DriveBuilder, OnlyTheLongestPartBetweenClockJumpsIsUsed) {
  for (const TimeNs jump : {20'000'000l, -100'000'000l, 5'000'000'000l}) {
    TestMessages test;  // no offset would be right for both parts
    for (std::size_t i = 200; i < 300; ++i) test.messages.imu[i].stamp += jump;
    EXPECT_EQ(test.Build().imu.size(), 200u) << jump;
    EXPECT_TRUE(IsNoted(test.notes.warnings, "topic /imu: 1 clock jump(s)")) << jump;
  }

  TestMessages test;
  for (std::size_t i = 12; i < 30; ++i) {
    test.messages.lidars[0][i].stamp -= 500'000'000;
    test.messages.lidars[0][i].start -= 500'000'000;
  }
  const Drive drive = test.Build();
  EXPECT_TRUE(IsNoted(test.notes.warnings, "topic /points: 1 clock jump(s)"));
  EXPECT_TRUE(IsNoted(test.notes.warnings, "only the longest part between jumps"));
  ASSERT_EQ(drive.lidars[0].scans.size(), 18u);
  EXPECT_NEAR(drive.lidars[0].scans.front().time, 0.7, 1e-6);
}

TEST(DriveBuilder, ChangeOfScanPeriodIsReported) {
  TestMessages test;
  std::vector<ReadScan>& scans = test.messages.lidars[0];
  scans.clear();
  for (int i = 0; i < 120; ++i) {
    if (i < 70 || i % 2 == 0) scans.push_back(TestMessages::Scan(i));
  }
  test.Build();
  EXPECT_TRUE(IsNoted(test.notes.warnings, "topic /points: the period changes: 0.2 s"));
}

}  // namespace
}  // namespace mlic::drive_builder_test
