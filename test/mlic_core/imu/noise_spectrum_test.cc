#include "mlic_core/imu/noise_spectrum.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mlic_core/common/random.h"

namespace mlic::noise_spectrum_test {
namespace {

constexpr double kRate = 200.0;

Eigen::VectorXd WhiteNoise(int count, double sigma) {
  Random random(3);
  Eigen::VectorXd values(count);
  for (int i = 0; i < count; ++i) values[i] = sigma * random.Normal();
  return values;
}

TEST(NoiseSpectrum, WhiteNoiseHasItsVarianceInEveryBand) {
  for (const int count : {4000, 20011}) {
    const NoiseSpectrum spectrum(WhiteNoise(count, 0.3), kRate);
    EXPECT_NEAR(spectrum.Variance(0.0, 100.1), 0.09, 0.01);
    EXPECT_NEAR(spectrum.Variance(10.0, 35.0), 0.09 / 4.0, 0.005);
    EXPECT_NEAR(spectrum.WhiteVariance(10.0, 35.0), 0.09, 0.02);
    EXPECT_NEAR(spectrum.WhiteVariance(60.0, 90.0), 0.09, 0.02);
  }
}

TEST(NoiseSpectrum, ALineCountsInItsBandAlone) {
  Eigen::VectorXd values = WhiteNoise(4000, 0.01);
  for (int i = 0; i < values.size(); ++i) values[i] += 5.0 + 3.0 * std::sin(2.0 * M_PI * 71.3 * i / kRate);
  const NoiseSpectrum spectrum(values, kRate);
  EXPECT_NEAR(spectrum.Variance(70.0, 73.0), 4.5, 0.05);
  EXPECT_NEAR(spectrum.Variance(0.0, 50.0), 1e-4 / 2.0, 2e-5);
  EXPECT_NEAR(spectrum.WhiteVariance(60.0, 80.0), 1e-4, 4e-5);
}

TEST(NoiseSpectrum, AFewSamplesHaveNone) {
  const NoiseSpectrum spectrum(WhiteNoise(40, 1.0), kRate);
  EXPECT_EQ(spectrum.Variance(0.0, 100.0), 0.0);
  EXPECT_EQ(spectrum.WhiteVariance(0.0, 100.0), 0.0);
}

}  // namespace
}  // namespace mlic::noise_spectrum_test
