#include "mlic_core/uncertainty/imu_noise.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mlic_core/common/random.h"
#include "mlic_sim/imu_simulator.h"
#include "support/true_spline.h"

namespace mlic::imu_noise_test {
namespace {

constexpr double kDuration = 40.0;

// What an IMU at rest reads, less what it should: residuals of a spline that follows none of it.
ImuResiduals AtRest(const sim::SimulatedImu& imu, std::uint64_t seed) {
  sim::ImuSimulator simulator(imu, true, Random(seed));
  const auto rest = [](double) {
    sim::MotionState state;
    state.velocity.setZero();
    state.acceleration.setZero();
    state.angular_velocity.setZero();
    return state;
  };
  ImuResiduals residuals;
  for (int k = 0; k < kDuration * imu.rate; ++k) {
    const ImuSample sample = simulator.Next(k / imu.rate, rest);
    residuals.times.push_back(sample.time);
    residuals.values.emplace_back();
    residuals.values.back() << sample.angular_velocity, sample.specific_force - Eigen::Vector3d(0, 0, 9.81);
  }
  return residuals;
}

SplitSpline WithKnotsEvery(double spacing) {
  const UniformKnots knots = UniformKnots::Covering(0.0, kDuration, spacing);
  return {So3Spline(knots, std::vector<Eigen::Quaterniond>(knots.count, Eigen::Quaterniond::Identity())),
          PositionSpline(knots, std::vector<Eigen::Vector3d>(knots.count, Eigen::Vector3d::Zero()))};
}

sim::SimulatedImu Mems() {
  sim::SimulatedImu imu;
  imu.noise = {1e-3, 1e-2};
  return imu;
}

TEST(ImuSigma, OfWhiteNoiseIsItsScatter) {
  const double root_rate = std::sqrt(200.0);
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const ImuSigma sigma = MeasureImuSigma(AtRest(Mems(), seed), WithKnotsEvery(0.05), {}).usual;
    for (int a = 0; a < 3; ++a) {
      EXPECT_NEAR(sigma.gyroscope[a], 1e-3 * root_rate, 0.05e-3 * root_rate);
      EXPECT_NEAR(sigma.accelerometer[a], 1e-2 * root_rate, 0.05e-2 * root_rate);
    }
  }
}

TEST(ImuSigma, OfFilteredNoiseIsThatOfItsDensity) {
  sim::SimulatedImu imu = Mems();
  imu.gyroscope_low_pass = imu.accelerometer_low_pass = 0.1;
  const double root_rate = std::sqrt(200.0);
  const ImuSigma sigma = MeasureImuSigma(AtRest(imu, 2), WithKnotsEvery(0.08), {}).usual;
  for (int a = 0; a < 3; ++a) {
    EXPECT_NEAR(sigma.gyroscope[a], 1e-3 * root_rate, 0.15e-3 * root_rate);
    EXPECT_NEAR(sigma.accelerometer[a], 1e-2 * root_rate, 0.15e-2 * root_rate);
  }
}

TEST(ImuSigma, IsNeverBelowTheGivenOne) {
  const ImuSigma given{Eigen::Vector3d::Constant(0.5), Eigen::Vector3d::Constant(0.6)};
  const ImuSigma sigma = MeasureImuSigma(AtRest(Mems(), 1), WithKnotsEvery(0.05), given).usual;
  EXPECT_EQ(sigma.gyroscope, given.gyroscope);
  EXPECT_EQ(sigma.accelerometer, given.accelerometer);
}

TEST(ImuSigma, OfEvenNoiseHasNoStretches) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    EXPECT_TRUE(MeasureImuSigma(AtRest(Mems(), seed), WithKnotsEvery(0.05), {}).growth.empty()) << seed;
  }
}

// A knock from 10 to 11 s and a shaken stretch from 20 to 28 s leave the others their sigmas.
TEST(ImuSigma, GrowsOverStretchesThatShake) {
  const double root_rate = std::sqrt(200.0);
  ImuResiduals residuals = AtRest(Mems(), 4);
  Random random(5);
  for (std::size_t k = 0; k < residuals.times.size(); ++k) {
    const double time = residuals.times[k];
    const double growth = time >= 10.0 && time < 11.0 ? 10.0 : time >= 20.0 && time < 28.0 ? 3.0 : 0.0;
    for (int a = 0; a < 6; ++a) {
      residuals.values[k][a] += growth * (a < 3 ? 1e-3 : 1e-2) * root_rate * random.Normal();
    }
  }
  const ImuSigmaCourse sigma = MeasureImuSigma(residuals, WithKnotsEvery(0.05), {});
  ASSERT_EQ(sigma.growth.size(), 10u);
  for (int a = 0; a < 3; ++a) {
    EXPECT_NEAR(sigma.usual.gyroscope[a], 1e-3 * root_rate, 0.05e-3 * root_rate);
    EXPECT_NEAR(sigma.usual.accelerometer[a], 1e-2 * root_rate, 0.05e-2 * root_rate);
  }
  for (const double time : {1.0, 5.0, 13.0, 17.0, 30.0, 39.0}) {
    EXPECT_EQ(sigma.At(time).gyroscope, sigma.usual.gyroscope) << time;
  }
  EXPECT_GT(sigma.At(10.5).accelerometer[0], 2.5 * sigma.usual.accelerometer[0]);
  for (const double time : {21.0, 25.0}) {
    EXPECT_NEAR(sigma.At(time).accelerometer[0], std::sqrt(10.0) * 1e-2 * root_rate, 0.3e-2 * root_rate);
  }
}

// A jump at some level of noise would let the rounds of a calibration alternate between its two sides.
TEST(ImuSigma, GrowsWithoutAJump) {
  const ImuResiduals even = AtRest(Mems(), 6);
  double before = 1.0;
  for (double factor = 1.0; factor < 2.5; factor += 0.01) {
    ImuResiduals residuals = even;
    for (std::size_t k = 0; k < residuals.times.size(); ++k) {
      if (residuals.times[k] >= 20.0 && residuals.times[k] < 24.0) residuals.values[k] *= factor;
    }
    const ImuSigmaCourse sigma = MeasureImuSigma(residuals, WithKnotsEvery(0.05), {});
    const double growth = sigma.At(22.0).gyroscope[0] / sigma.usual.gyroscope[0];
    EXPECT_LT(std::abs(growth - before), 0.06) << factor;
    before = growth;
  }
  EXPECT_NEAR(before, 2.5, 0.1);
}

TEST(ImuMeanExcess, WhiteNoiseHasNone) {
  const ImuSigma sigma{Eigen::Vector3d::Constant(1e-3 * std::sqrt(200.0)),
                       Eigen::Vector3d::Constant(1e-2 * std::sqrt(200.0))};
  int beyond = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const ImuMeanExcess excess = MeasureMeanExcess(AtRest(Mems(), seed), {sigma});
    for (const double variance : excess.variance) {
      beyond += variance > 1.0;
      EXPECT_LT(variance, 1.5) << seed;
    }
  }
  EXPECT_LE(beyond, 2);
}

// A bias of the accelerometer that changes by 4 sigmas (root mean square) of a mean over 5 s, within single
// samples' noise.
TEST(ImuMeanExcess, SlowErrorsStandOut) {
  ImuResiduals residuals = AtRest(Mems(), 3);
  const ImuSigma sigma{Eigen::Vector3d::Constant(1e-3 * std::sqrt(200.0)),
                       Eigen::Vector3d::Constant(1e-2 * std::sqrt(200.0))};
  for (std::size_t k = 0; k < residuals.times.size(); ++k) {
    residuals.values[k].tail<3>().array() +=
        4.0 * 1e-2 / std::sqrt(5.0) * std::sqrt(2.0) * std::sin(2.0 * M_PI * residuals.times[k] / 25.0);
  }
  const ImuMeanExcess excess = MeasureMeanExcess(residuals, {sigma});
  EXPECT_LT(excess.variance[0], 1.1);
  EXPECT_GT(excess.variance[1], 5.0);
  EXPECT_GE(excess.seconds[1], 5.0);
}

}  // namespace
}  // namespace mlic::imu_noise_test
