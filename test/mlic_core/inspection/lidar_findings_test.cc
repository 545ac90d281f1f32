#include "mlic_core/inspection/lidar_findings.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "mlic_core/inspection/find_finding.h"

namespace mlic::lidar_findings_test {
namespace {

constexpr TimeNs kBegin = 1'700'000'000'000'000'000;
constexpr int kColumns = 500, kRings = 8;
constexpr double kPeriod = 0.1;  // s

LidarFormat Format() {
  LidarFormat format;
  format.topic = "/points";
  format.time_field = "time";
  return format;
}

// A revolution within walls at `distance`; turning: rad/s that a de-skewing driver has added to the azimuths.
DecodedCloud Revolution(TimeNs stamp, double distance, double turning) {
  DecodedCloud cloud;
  cloud.stamp = stamp;
  cloud.times.push_back({"time", {}});
  for (int i = 0; i < kColumns * kRings; ++i) {
    const double time = kPeriod * (i / kRings) / kColumns;
    const double azimuth = -2.0 * M_PI * time / kPeriod + turning * time;
    cloud.positions.emplace_back(distance * std::cos(azimuth), distance * std::sin(azimuth),
                                 0.2 * (i % kRings));
    cloud.intensities.push_back(static_cast<float>(i % 7));
    cloud.rings.push_back(static_cast<std::uint16_t>(i % kRings));
    cloud.times[0].values.push_back(time);
  }
  return cloud;
}

double Turning(double time) { return 0.4 * std::sin(0.7 * time); }

// de_skewed: share of the turning that the driver has taken out.
LidarSurvey Survey(double distance, double de_skewed = 0.0) {
  LidarSurvey lidar{"lidar", Format(), "", 400, 0, "", {}};
  for (int i = 0; i < 40; ++i) {
    const double time = 1.0 * i;
    const DecodedCloud cloud =
        Revolution(TimeFrom(kBegin, time), distance, de_skewed * Turning(time + 0.5 * kPeriod));
    lidar.samples.push_back(MeasureScan(cloud, *lidar.format));
  }
  return lidar;
}

TEST(LidarFindings, PassesASoundLidar) {
  for (const Finding& finding : LidarFindings(Survey(20.0), true))
    EXPECT_EQ(finding.grade, Grade::kPass) << FindingLine(finding);
}

TEST(LidarFindings, TellsRangesThatNoLidarHas) {
  EXPECT_EQ(FindingOf(LidarFindings(Survey(1.0), false), "ranges").grade, Grade::kFail);
  EXPECT_EQ(FindingOf(LidarFindings(Survey(20000.0), false), "ranges").grade, Grade::kFail);
}

TEST(LidarFindings, CountsReturnsAndFaults) {
  LidarSurvey lidar = Survey(20.0);
  for (ScanSample& sample : lidar.samples) sample.returns = sample.points / 20;
  EXPECT_EQ(FindingOf(LidarFindings(lidar, false), "returns").grade, Grade::kWarn);
  lidar.malformed = 30;
  EXPECT_EQ(FindingOf(LidarFindings(lidar, false), "messages").grade, Grade::kWarn);
  for (ScanSample& sample : lidar.samples) sample.intensity_varies = false;
  EXPECT_EQ(FindingOf(LidarFindings(lidar, false), "intensity").check, "absent");
  EXPECT_EQ(FindingOf(LidarFindings(lidar, true), "intensity").grade, Grade::kWarn);
}

TEST(LidarFindings, TellsPointTimes) {
  LidarSurvey lidar = Survey(20.0);
  lidar.format->time_field.clear();
  EXPECT_EQ(FindingOf(LidarFindings(lidar, false), "point times").grade, Grade::kWarn);
  lidar.format.reset();
  lidar.format_error = "topic /points: the points have no times";
  EXPECT_EQ(FindingOf(LidarFindings(lidar, false), "point times").grade, Grade::kFail);
}

TEST(DeskewFindings, TellRawFromDeskewedScans) {
  std::vector<ImuSample> imu;
  for (int i = 0; i < 8000; ++i) {
    const double time = 0.005 * i;
    imu.push_back({time, {0.0, 0.01 * std::sin(time), Turning(time)}, {0.0, 0.0, 9.81}});
  }
  EXPECT_EQ(DeskewFindings(Survey(20.0), imu, kBegin).at(0).grade, Grade::kPass);
  EXPECT_EQ(DeskewFindings(Survey(20.0, 1.0), imu, kBegin).at(0).grade, Grade::kFail);
  for (ImuSample& sample : imu) sample.angular_velocity.setZero();
  EXPECT_TRUE(DeskewFindings(Survey(20.0), imu, kBegin).empty());
}

}  // namespace
}  // namespace mlic::lidar_findings_test
