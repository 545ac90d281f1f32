#include "mlic_core/inspection/imu_findings.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "mlic_core/inspection/excitation_findings.h"
#include "mlic_core/inspection/find_finding.h"

namespace mlic::imu_findings_test {
namespace {

constexpr TimeNs kBegin = 1'700'000'000'000'000'000;
constexpr double kRate = 200.0;  // Hz

// Turning about the axes with these amplitudes (rad/s), on its side: up is -y.
std::vector<StampedImu> Moving(const Eigen::Vector3d& amplitude, double seconds = 40.0) {
  std::vector<StampedImu> samples;
  std::mt19937 random(1);
  std::normal_distribution<double> noise;
  const auto white = [&] { return Eigen::Vector3d(noise(random), noise(random), noise(random)); };
  for (int i = 0; i < static_cast<int>(kRate * seconds); ++i) {
    const double t = i / kRate;
    const Eigen::Vector3d waves(std::sin(2.1 * t), std::sin(1.7 * t + 1.0), std::sin(1.3 * t + 2.0));
    const TimeNs stamp = TimeFrom(kBegin, t);
    const bool rests = amplitude.norm() == 0.0;
    const Eigen::Vector3d shake = rests ? Eigen::Vector3d::Zero() : Eigen::Vector3d(0.5 * waves);
    samples.push_back({stamp, stamp, amplitude.cwiseProduct(waves) + 2e-3 * white(),
                       Eigen::Vector3d(0.0, -9.79, 0.3) + shake + 0.02 * white()});
  }
  return samples;
}

const Eigen::Vector3d kAllAxes(0.5, 0.4, 0.6);

Finding Imu(const std::vector<StampedImu>& samples, const std::string& check) {
  return FindingOf(ImuFindings("imu", samples, kBegin), check);
}

TEST(ImuFindings, PassesASoundImu) {
  for (const Finding& finding : ImuFindings("imu", Moving(kAllAxes), kBegin))
    EXPECT_EQ(finding.grade, Grade::kPass) << FindingLine(finding);
  EXPECT_NE(Imu(Moving(kAllAxes), "gravity").measured.find("up is the IMU's -y"), std::string::npos);
}

TEST(ImuFindings, RecognisesUnits) {
  std::vector<StampedImu> samples = Moving(kAllAxes);
  for (StampedImu& s : samples) s.specific_force /= 9.80665;
  EXPECT_EQ(Imu(samples, "units").grade, Grade::kFail);
  EXPECT_NE(Imu(samples, "units").measured.find("looks like g"), std::string::npos);
  samples = Moving(kAllAxes);
  for (StampedImu& s : samples) s.angular_velocity *= 180.0 / M_PI;
  EXPECT_NE(Imu(samples, "units").measured.find("deg/s"), std::string::npos);
  EXPECT_TRUE(UsableImu(samples).samples.empty());
}

TEST(ImuFindings, TellsAScaleError) {
  std::vector<StampedImu> samples = Moving(Eigen::Vector3d::Zero());
  for (StampedImu& s : samples) s.specific_force *= 1.05;
  EXPECT_EQ(Imu(samples, "gravity").grade, Grade::kWarn);
}

TEST(ImuFindings, FindsSaturationOfAnAxis) {
  std::vector<StampedImu> samples = Moving(kAllAxes);
  for (StampedImu& s : samples) s.angular_velocity.z() = std::min(s.angular_velocity.z(), 0.5);
  const Finding finding = Imu(samples, "saturation");
  EXPECT_EQ(finding.grade, Grade::kWarn);
  EXPECT_NE(finding.measured.find("gyroscope z"), std::string::npos) << finding.measured;
}

TEST(ImuFindings, FindsAFrozenAxis) {
  std::vector<StampedImu> samples = Moving(kAllAxes);
  for (std::size_t i = 2000; i < 2400; ++i) samples[i].specific_force.x() = 0.25;
  const Finding part = Imu(samples, "frozen axis");
  EXPECT_EQ(part.grade, Grade::kWarn);
  EXPECT_NE(part.measured.find("accelerometer x, 400 samples"), std::string::npos) << part.measured;
  EXPECT_NE(part.measured.find("at 10.00 s"), std::string::npos) << part.measured;
  for (StampedImu& s : samples) s.angular_velocity.y() = 0.0;
  EXPECT_EQ(Imu(samples, "frozen axis").grade, Grade::kFail);
}

TEST(ImuFindings, FindsHangsSpikesAndNan) {
  std::vector<StampedImu> samples = Moving(kAllAxes);
  for (std::size_t i = 1000; i < 1100; ++i) {
    samples[i].angular_velocity = samples[999].angular_velocity;
    samples[i].specific_force = samples[999].specific_force;
  }
  samples[3000].angular_velocity.x() += 5.0;
  for (std::size_t i = 5000; i < 5100; ++i)
    samples[i].specific_force.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(Imu(samples, "repeated readings").grade, Grade::kWarn);
  EXPECT_NE(Imu(samples, "spikes").measured.find("1 samples"), std::string::npos);
  EXPECT_EQ(Imu(samples, "NaN or infinite values").grade, Grade::kWarn);
}

TEST(ExcitationFindings, TellsAxesThatTurn) {
  const auto rotation = [](const Eigen::Vector3d& amplitude) {
    return FindingOf(ExcitationFindings(UsableImu(Moving(amplitude)).samples), "rotation").grade;
  };
  EXPECT_EQ(rotation(kAllAxes), Grade::kPass);
  EXPECT_EQ(rotation({0.0, 0.5, 0.0}), Grade::kWarn);
  EXPECT_EQ(rotation({0.0, 0.0, 0.01}), Grade::kFail);
}

TEST(ExcitationFindings, MeasuresRest) {
  std::vector<StampedImu> samples = Moving(Eigen::Vector3d::Zero());
  EXPECT_EQ(FindingOf(ExcitationFindings(UsableImu(samples).samples), "at rest").grade, Grade::kWarn);
  const std::vector<StampedImu> moving = Moving(kAllAxes);
  std::copy(moving.begin() + 2000, moving.begin() + 6000, samples.begin() + 2000);
  EXPECT_EQ(FindingOf(ExcitationFindings(UsableImu(samples).samples), "at rest").grade, Grade::kPass);
  const std::vector<ImuSample> usable = UsableImu(samples).samples;
  const std::vector<MotionPart> parts = MotionOverTime(usable, RoughGyroscopeBias(usable), 10.0);
  ASSERT_EQ(parts.size(), 4u);
  EXPECT_GT(parts[0].rest, 9.0);
  EXPECT_EQ(parts[1].rest, 0.0);
  EXPECT_NEAR(parts[1].angular_velocity_rms.z(), 0.6 / std::sqrt(2.0), 0.1);
  EXPECT_EQ(MotionTable(parts).size(), 5u);
}

}  // namespace
}  // namespace mlic::imu_findings_test
