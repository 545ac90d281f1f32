#include "mlic_core/inspection/stamp_findings.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "mlic_core/inspection/find_finding.h"

namespace mlic::stamp_findings_test {
namespace {

constexpr TimeNs kBegin = 1'700'000'000'000'000'000;

// A steady topic whose messages arrive 2 ms late, and up to jitter seconds more.
SensorTimes Steady(SensorKind kind, double rate, double seconds, double jitter = 1e-3) {
  SensorTimes sensor{"sensor", kind, {}};
  std::mt19937 random(1);
  std::exponential_distribution<double> delay(3.0);
  for (int i = 0; i < static_cast<int>(rate * seconds); ++i) {
    const TimeNs stamp = TimeFrom(kBegin, i / rate);
    sensor.messages.push_back({stamp, TimeFrom(stamp, 2e-3 + jitter * delay(random))});
  }
  return sensor;
}

Findings Stamps(const SensorTimes& sensor) { return StampFindings(sensor, ClockOf(sensor), kBegin); }

Finding Stamps(const SensorTimes& sensor, const std::string& check) {
  return FindingOf(Stamps(sensor), check);
}

TEST(StampFindings, PassesASteadyTopic) {
  for (const double jitter : {1e-4, 1e-3, 5e-3}) {
    for (const Finding& finding : Stamps(Steady(SensorKind::kImu, 200.0, 60.0, jitter)))
      EXPECT_EQ(finding.grade, Grade::kPass) << FindingLine(finding);
    for (const Finding& finding : Stamps(Steady(SensorKind::kLidar, 10.0, 60.0, jitter)))
      EXPECT_EQ(finding.grade, Grade::kPass) << FindingLine(finding);
  }
}

TEST(StampFindings, TellsTheRate) {
  EXPECT_EQ(Stamps(Steady(SensorKind::kImu, 30.0, 20.0), "rate").grade, Grade::kWarn);
  EXPECT_EQ(Stamps(Steady(SensorKind::kImu, 4.0, 20.0), "rate").grade, Grade::kFail);
  SensorTimes still = Steady(SensorKind::kLidar, 10.0, 20.0);
  for (MessageTimes& m : still.messages) m.stamp = kBegin;
  EXPECT_EQ(Stamps(still, "rate").grade, Grade::kFail);
}

TEST(StampFindings, PlacesGaps) {
  SensorTimes sensor = Steady(SensorKind::kLidar, 10.0, 60.0);
  sensor.messages.erase(sensor.messages.begin() + 200, sensor.messages.begin() + 225);
  const Finding gaps = Stamps(sensor, "gaps");
  EXPECT_EQ(gaps.grade, Grade::kWarn);
  EXPECT_NE(gaps.measured.find("1, 2.60 s in all"), std::string::npos) << gaps.measured;
  EXPECT_NE(gaps.measured.find("at 19.9"), std::string::npos) << gaps.measured;
  sensor.messages.erase(sensor.messages.begin() + 200, sensor.messages.end() - 20);
  EXPECT_EQ(Stamps(sensor, "gaps").grade, Grade::kFail);
}

TEST(StampFindings, CountsLostDoubledAndLateMessages) {
  SensorTimes sensor = Steady(SensorKind::kImu, 200.0, 30.0, 0.0);
  for (std::size_t i = sensor.messages.size(); i-- > 0;) {
    if (i % 10 == 3) sensor.messages.erase(sensor.messages.begin() + static_cast<std::ptrdiff_t>(i));
  }
  EXPECT_EQ(Stamps(sensor, "lost messages").grade, Grade::kWarn);
  EXPECT_EQ(Stamps(sensor, "order").grade, Grade::kPass);
  for (std::size_t i = 100; i < 200; i += 10) sensor.messages[i].stamp = sensor.messages[i - 1].stamp;
  for (std::size_t i = 300; i < 400; i += 10)
    std::swap(sensor.messages[i].stamp, sensor.messages[i - 1].stamp);
  const Finding order = Stamps(sensor, "order");
  EXPECT_EQ(order.grade, Grade::kWarn);
  EXPECT_NE(order.measured.find("10 out of order, 10 with a repeated stamp"), std::string::npos)
      << order.measured;
}

TEST(StampFindings, FindsJumpsOfTheClock) {
  for (const double step : {0.006, -0.02, 0.1, -0.1, 0.4, 10.0}) {
    SCOPED_TRACE(step);
    SensorTimes sensor = Steady(SensorKind::kLidar, 10.0, 60.0);
    for (std::size_t i = 300; i < sensor.messages.size(); ++i)
      sensor.messages[i].stamp = TimeFrom(sensor.messages[i].stamp, step);
    const ClockFit clock = FitClock(sensor.messages);
    ASSERT_EQ(clock.jumps.size(), 1u);
    EXPECT_EQ(clock.jumps[0].index, 300u);
    EXPECT_NEAR(clock.jumps[0].step, step, 2e-3);
    EXPECT_LT(std::abs(clock.drift_ppm), 5.0 * clock.drift_sigma_ppm);
    EXPECT_EQ(Stamps(sensor, "clock jumps").grade, Grade::kWarn);
  }
}

TEST(StampFindings, LateMessagesAreNoJump) {
  SensorTimes sensor = Steady(SensorKind::kCamera, 20.0, 60.0);
  for (std::size_t i = 400; i < 420; ++i)  // a burst after a second of silence
    sensor.messages[i].record = TimeFrom(sensor.messages[420].record, -1e-5 * static_cast<double>(420 - i));
  EXPECT_EQ(Stamps(sensor, "clock jumps").grade, Grade::kPass);
  EXPECT_EQ(Stamps(sensor, "gaps").grade, Grade::kPass);
}

TEST(StampFindings, TellsStampsOnArrival) {
  SensorTimes sensor = Steady(SensorKind::kCamera, 20.0, 60.0, 5e-3);
  EXPECT_EQ(Stamps(sensor, "stamps").check, "absent");
  for (MessageTimes& m : sensor.messages) m.stamp = TimeFrom(m.record, -1e-4);
  EXPECT_EQ(Stamps(sensor, "stamps").grade, Grade::kWarn);
}

TEST(StampFindings, MeasuresDrift) {
  const SensorTimes imu = Steady(SensorKind::kImu, 200.0, 60.0);
  SensorTimes lidar = Steady(SensorKind::kLidar, 10.0, 60.0, 3e-4);
  EXPECT_EQ(DriftFindings(lidar, ClockOf(lidar), ClockOf(imu)).at(0).grade, Grade::kPass);
  for (MessageTimes& m : lidar.messages) m.stamp = TimeFrom(m.stamp, 1e-4 * SecondsSince(kBegin, m.stamp));
  EXPECT_NEAR(FitClock(lidar.messages).drift_ppm, 100.0, 5.0);
  EXPECT_EQ(DriftFindings(lidar, ClockOf(lidar), ClockOf(imu)).at(0).grade, Grade::kWarn);
}

TEST(StampFindings, MeasuresOverlap) {
  const SensorTimes imu = Steady(SensorKind::kImu, 200.0, 60.0);
  SensorTimes lidar = Steady(SensorKind::kLidar, 10.0, 60.0);
  EXPECT_EQ(OverlapFindings(lidar, imu).at(0).grade, Grade::kPass);
  lidar.messages.resize(300);
  EXPECT_EQ(OverlapFindings(lidar, imu).at(0).grade, Grade::kWarn);
  for (MessageTimes& m : lidar.messages) m.stamp -= kBegin;
  EXPECT_EQ(OverlapFindings(lidar, imu).at(0).grade, Grade::kFail);
}

}  // namespace
}  // namespace mlic::stamp_findings_test
