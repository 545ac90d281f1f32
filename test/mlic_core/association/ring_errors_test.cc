#include "mlic_core/association/ring_errors.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <cmath>

#include "mlic_core/common/random.h"

namespace mlic::ring_errors_test {
namespace {

constexpr int kRings = 64;

// Below a third of the rings ground alone is met: of range and elevation it shows one sum, and `weakly` so
// many times less of what is across it.
Eigen::Matrix2d InformationOf(int ring, double weakly) {
  constexpr double kWall = 1.0 / (3e-4 * 3e-4);  // of the range; 1/m^2
  const bool ground = ring < kRings / 3;
  const Eigen::Vector2d shown(1.0, ground ? -12.0 : 1.0), across(0.0, ground ? 1.0 : 5.0);
  return kWall * (shown * shown.transpose() + (ground ? weakly : 1.0) * across * across.transpose());
}

// Rings that err by `errors`, seen with noise of the information's size.
std::vector<RingEquations> Seen(const Eigen::MatrixX2d& errors, Random* random) {
  std::vector<RingEquations> rings(kRings);
  for (int i = 0; i < kRings; ++i) {
    rings[i].information = InformationOf(i, 1e-2);
    const Eigen::Matrix2d root = rings[i].information.llt().matrixL();
    const Eigen::Vector2d noise(random->Normal(), random->Normal());
    rings[i].gradient = -(rings[i].information * errors.row(i).transpose() + root * noise);
  }
  return rings;
}

// Orthonormal: mean and slope.
Eigen::MatrixXd Trend() {
  Eigen::MatrixXd trend(kRings, 2);
  for (int i = 0; i < kRings; ++i) trend.row(i) << 1.0, i - 0.5 * (kRings - 1);
  return trend * trend.colwise().norm().cwiseInverse().asDiagonal();
}

Eigen::MatrixX2d Drawn(double range, double elevation, Random* random) {
  Eigen::MatrixX2d errors(kRings, 2);
  for (int i = 0; i < kRings; ++i) errors.row(i) << range * random->Normal(), elevation * random->Normal();
  return errors;
}

TEST(RingErrors, AreAsWideAsTheyWereDrawn) {
  Random random(1);
  const RingVariances found = MeasureRingVariances(Seen(Drawn(5e-3, 3e-4, &random), &random), true);
  EXPECT_NEAR(std::sqrt(found.variances[0]), 5e-3, 1.5e-3);
  EXPECT_NEAR(std::sqrt(found.variances[1]), 3e-4, 1.2e-4);
  EXPECT_GT(found.evidence, 50.0);
}

// Noise of rings that see ground alone is 0.3 mm of the sum, but many times that of range and elevation.
TEST(RingErrors, AreNoneForNoiseOfRingsThatSeeGround) {
  for (int seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    const std::vector<RingEquations> rings = Seen(Drawn(0.0, 0.0, &random), &random);
    const RingVariances found = MeasureRingVariances(rings, true);
    EXPECT_LT(found.evidence, 4.0) << seed;
    EXPECT_LT(PredictRingErrors(rings, Trend(), found.variances).col(0).cwiseAbs().maxCoeff(), 3e-4) << seed;
  }
}

// An error that grows smoothly to 20 mm, and jumps where the ground ends.
TEST(RingErrors, AreNoneForWhatNeighboursShare) {
  Random random(2);
  Eigen::MatrixX2d errors = Eigen::MatrixX2d::Zero(kRings, 2);
  for (int i = 0; i < kRings / 3; ++i) errors(i, 0) = 0.02 * std::pow(3.0 * i / kRings, 2);
  const RingVariances found = MeasureRingVariances(Seen(errors, &random), true);
  EXPECT_LT(std::sqrt(found.variances[0]), 2e-3);
}

TEST(RingErrors, ArePredictedWithoutTheirTrend) {
  Random random(3);
  const Eigen::MatrixX2d errors = Drawn(5e-3, 0.0, &random);
  const std::vector<RingEquations> rings = Seen(errors, &random);
  const Eigen::MatrixXd trend = Trend();
  const Eigen::MatrixX2d found = PredictRingErrors(rings, trend, {25e-6, 0.0});
  EXPECT_LT((trend.transpose() * found).norm(), 1e-9);
  EXPECT_EQ(found.col(1).norm(), 0.0);
  const Eigen::VectorXd left = errors.col(0) - trend * (trend.transpose() * errors.col(0)) - found.col(0);
  EXPECT_LT(left.norm() / std::sqrt(double{kRings}), 0.6e-3);
}

TEST(RingErrors, LowerTheCostOfOtherPointsIfTheyAreReal) {
  Random random(4);
  const Eigen::MatrixXd trend = Trend();
  const Eigen::MatrixX2d errors = Drawn(2e-3, 1e-4, &random), others = Drawn(2e-3, 1e-4, &random);
  const Eigen::MatrixX2d predicted = PredictRingErrors(Seen(errors, &random), trend, {4e-6, 1e-8});
  EXPECT_GT(GainOfCorrections(Seen(errors, &random), trend, predicted), 100.0);
  EXPECT_LT(GainOfCorrections(Seen(others, &random), trend, predicted), 0.0);
  // A trend is no gain.
  const Eigen::MatrixX2d along = 0.01 * trend;
  EXPECT_NEAR(GainOfCorrections(Seen(errors, &random), trend, along), 0.0, 1e-3);
}

// Of four parts, each of which sees rings that err by `same` and by `own` of the part, about what all show.
double Scatter(const Eigen::MatrixX2d& same, double own, std::uint64_t seed) {
  Random random(seed);
  std::vector<std::vector<RingEquations>> parts;
  std::vector<RingEquations> all(kRings);
  for (int part = 0; part < 4; ++part) {
    Eigen::MatrixX2d errors = same + Drawn(own, 0.0, &random);
    errors.col(0) += part * 0.01 * Trend().col(1);  // a trend of its own
    parts.push_back(Seen(errors, &random));
    for (int i = 0; i < kRings; ++i) {
      all[i].information += parts.back()[i].information;
      all[i].gradient += parts.back()[i].gradient;
    }
  }
  return ScatterOfParts(parts, Trend(), PredictRingErrors(all, Trend(), {25e-6, 9e-8}));
}

TEST(RingErrors, OfPartsScatterByTheirNoiseWhereTheyAreReal) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Random random(100 + seed);
    const Eigen::MatrixX2d errors = Drawn(5e-3, 3e-4, &random);
    EXPECT_NEAR(Scatter(errors, 0.0, seed), 1.0, 0.2) << seed;
    // Three times the noise of a ring's range.
    EXPECT_GT(Scatter(errors, 9e-4, seed), 3.0) << seed;
  }
}

TEST(RingErrors, AreInRangeAloneWhereElevationsAreNotAsked) {
  Random random(5);
  const RingVariances found = MeasureRingVariances(Seen(Drawn(5e-3, 3e-4, &random), &random), false);
  EXPECT_GT(found.variances[0], 0.0);
  EXPECT_EQ(found.variances[1], 0.0);
}

}  // namespace
}  // namespace mlic::ring_errors_test
