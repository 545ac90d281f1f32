#include "mlic_core/inspection/forecast.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "mlic_core/geometry/so3.h"
#include "mlic_core/inspection/find_finding.h"

namespace mlic::forecast_test {
namespace {

constexpr double kRate = 200.0;          // Hz
constexpr double kGyroscope = 1e-3;      // rad/s/sqrt(Hz)
constexpr double kAccelerometer = 1e-2;  // m/s^2/sqrt(Hz)
constexpr double kFrequency = 2.0;       // rad/s, of the turning about z

// An IMU that turns about its axes with these amplitudes (rad/s) and shakes by a tenth of gravity, or rests.
std::vector<ImuSample> Turning(const Eigen::Vector3d& amplitude, double seconds) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise;
  const auto white = [&] { return Eigen::Vector3d(noise(random), noise(random), noise(random)); };
  std::vector<ImuSample> samples;
  Eigen::Quaterniond attitude = Eigen::Quaterniond::Identity();
  const double shake = amplitude.norm() > 0.0 ? 1.0 : 0.0;
  for (int i = 0; i < static_cast<int>(seconds * kRate); ++i) {
    const double t = i / kRate;
    const Eigen::Vector3d waves(std::sin(1.3 * t), std::sin(1.7 * t + 1.0), std::cos(kFrequency * t));
    const Eigen::Vector3d w = amplitude.cwiseProduct(waves);
    const Eigen::Vector3d force = Eigen::Vector3d(std::sin(0.9 * t), std::cos(1.1 * t), 0.0) * shake +
                                  Eigen::Vector3d(0.0, 0.0, kStandardGravity);
    samples.push_back({t, w + kGyroscope * std::sqrt(kRate) * white(),
                       attitude.conjugate() * force + kAccelerometer * std::sqrt(kRate) * white()});
    attitude = (attitude * ExpQuaternion(w / kRate)).normalized();
  }
  return samples;
}

ObservabilityForecast Forecast(const Eigen::Vector3d& amplitude, double seconds) {
  const auto forecast = ForecastObservability(Turning(amplitude, seconds), ImuConfig(), TypicalPoseNoise());
  EXPECT_TRUE(forecast.has_value());
  return forecast.value_or(ObservabilityForecast());
}

std::size_t CountOfUnseen(const ObservabilityForecast& forecast, const std::string& quantity) {
  std::size_t count = 0;
  for (const UnseenDirection& direction : forecast.unseen) count += direction.quantity == quantity;
  return count;
}

TEST(Forecast, MotionAboutAllAxesShowsEverything) {
  EXPECT_TRUE(Forecast({0.5, 0.6, 0.7}, 60.0).unseen.empty());
}

TEST(Forecast, MotionOnAPlaneHidesTheHeight) {
  const ObservabilityForecast forecast = Forecast({0.0, 0.0, 0.7}, 60.0);
  ASSERT_EQ(forecast.unseen.size(), 1u);
  EXPECT_EQ(forecast.unseen[0].quantity, "translation");
  EXPECT_GT(forecast.unseen[0].direction.z(), 0.99);
  EXPECT_NEAR(forecast.translation_sigma.z(), 0.1, 0.01);  // the guess
  EXPECT_LT(forecast.translation_sigma.head<2>().maxCoeff(), 0.03);
}

TEST(Forecast, NoiseIsNoMotionHoweverLong) {
  for (const double seconds : {20.0, 600.0}) {
    const ObservabilityForecast forecast = Forecast(Eigen::Vector3d::Zero(), seconds);
    EXPECT_EQ(CountOfUnseen(forecast, "rotation"), 3u);
    EXPECT_EQ(CountOfUnseen(forecast, "translation"), 3u);
    EXPECT_EQ(CountOfUnseen(forecast, "time_offset"), 1u);
  }
  EXPECT_FALSE(
      ForecastObservability(Turning({0.5, 0.5, 0.5}, 1.0), ImuConfig(), TypicalPoseNoise()).has_value());
}

// The gyroscope alone tells the offset: sigma = density / (amplitude * frequency * sqrt(T / 2)); the forces
// add to it.
TEST(Forecast, TimeOffsetIsThatOfTheClosedForm) {
  const double alone = kGyroscope / (0.7 * kFrequency * std::sqrt(30.0));
  const double sigma = Forecast({0.0, 0.0, 0.7}, 60.0).time_offset_sigma;
  EXPECT_LT(sigma, 1.1 * alone);
  EXPECT_GT(sigma, 0.5 * alone);
}

// Lever arms hang on where the poses are: less where these are bad along one axis than along all.
TEST(Forecast, FollowsThePosesNoise) {
  const std::vector<ImuSample> samples = Turning({0.5, 0.6, 0.7}, 60.0);
  const auto lever_arm = [&](const Eigen::Vector3d& factors) {
    PoseNoise poses = TypicalPoseNoise();
    poses.position.diagonal() = poses.position.diagonal().cwiseProduct(factors);
    const auto forecast = ForecastObservability(samples, ImuConfig(), poses);
    return forecast ? forecast->translation_sigma.norm() : 0.0;
  };
  const double typical = lever_arm({1.0, 1.0, 1.0}), all = lever_arm({1e6, 1e6, 1e6});
  EXPECT_GT(typical, 0.0);
  EXPECT_GT(all, 5.0 * typical);
  EXPECT_LT(lever_arm({1.0, 1.0, 1e6}), 0.5 * all);
}

TEST(Forecast, FailsASensorWithNothingToStandIn) {
  Rig rig;
  rig.lidars.emplace_back().name = "roof";
  const ObservabilityForecast forecast = Forecast({0.0, 0.0, 0.7}, 60.0);
  EXPECT_EQ(FindingOf(ForecastFindings(forecast, rig), "translation").grade, Grade::kWarn);
  EXPECT_EQ(FindingOf(ForecastFindings(forecast, rig), "link to the IMU").grade, Grade::kFail);
  rig.lidars[0].guess = ExtrinsicGuess();
  EXPECT_EQ(FindingOf(ForecastFindings(forecast, rig), "link to the IMU").check, "absent");
}

}  // namespace
}  // namespace mlic::forecast_test
