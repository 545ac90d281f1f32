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
RingEquations Seen(const Eigen::MatrixX2d& errors, Random* random) {
  RingEquations rings = RingEquations::Zero(kRings);
  for (int i = 0; i < kRings; ++i) {
    const Eigen::Matrix2d information = InformationOf(i, 1e-2);
    const Eigen::Matrix2d root = information.llt().matrixL();
    const Eigen::Vector2d noise(random->Normal(), random->Normal());
    const Eigen::Vector2d gradient = -(information * errors.row(i).transpose() + root * noise);
    for (int a = 0; a < 2; ++a) {
      rings.gradient[a * kRings + i] = gradient[a];
      for (int b = 0; b < 2; ++b) rings.information(a * kRings + i, b * kRings + i) = information(a, b);
    }
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
    const RingEquations rings = Seen(Drawn(0.0, 0.0, &random), &random);
    const RingVariances found = MeasureRingVariances(rings, true);
    EXPECT_LT(found.evidence, 4.0) << seed;
    const RingPrediction prediction = PredictRingErrors(WithoutTrend(rings, Trend()), found.variances);
    EXPECT_LT(prediction.errors.col(0).cwiseAbs().maxCoeff(), 3e-4) << seed;
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
  const Eigen::MatrixXd trend = Trend();
  const RingPrediction found = PredictRingErrors(WithoutTrend(Seen(errors, &random), trend), {25e-6, 0.0});
  EXPECT_LT((trend.transpose() * found.errors).norm(), 1e-9);
  EXPECT_EQ(found.errors.col(1).norm(), 0.0);
  const Eigen::VectorXd left =
      errors.col(0) - trend * (trend.transpose() * errors.col(0)) - found.errors.col(0);
  EXPECT_LT(left.norm() / std::sqrt(double{kRings}), 0.6e-3);
  // Of what is along the trend the data say nothing.
  const Eigen::MatrixXd of_ranges = found.covariance.topLeftCorner(kRings, kRings);
  for (int k = 0; k < 2; ++k) EXPECT_NEAR(trend.col(k).dot(of_ranges * trend.col(k)), 25e-6, 1e-9);
  const double expected = of_ranges.trace() - 2.0 * 25e-6;
  EXPECT_NEAR(left.squaredNorm() / expected, 1.0, 0.4);
}

// A mean that a plane's own errors hide: rings that differ from their neighbours alone are seen.
TEST(RingErrors, AreSeenThroughWhatPlanesShare) {
  Random random(6);
  const Eigen::MatrixX2d errors = Drawn(5e-3, 0.0, &random);
  RingEquations rings = Seen(errors, &random);
  constexpr int kWidth = 6;  // rings that see one plane
  RingEquations hidden = RingEquations::Zero(kRings);
  for (int first = 0; first + kWidth <= kRings; ++first) {
    const auto on_plane = [&](int i) { return i >= first && i < first + kWidth ? 1.0 : 0.0; };
    Eigen::MatrixXd of_plane = Eigen::MatrixXd::Zero(2 * kRings, 1);
    for (int i = 0; i < kRings; ++i) of_plane(i, 0) = on_plane(i) * std::sqrt(1e7 / kWidth);
    RingEquations plane = RingEquations::Zero(kRings);
    for (int i = 0; i < kRings; ++i) plane.information(i, i) = 1e7 * on_plane(i);
    plane.information -= of_plane * of_plane.transpose();
    Eigen::VectorXd stacked(2 * kRings);
    stacked << errors.col(0), errors.col(1);
    plane.gradient = -(plane.information * stacked);
    hidden.information += plane.information;
    hidden.gradient += plane.gradient;
  }
  const RingVariances found = MeasureRingVariances(hidden, false);
  EXPECT_NEAR(std::sqrt(found.variances[0]), 5e-3, 1.5e-3);
  const Eigen::MatrixXd trend = Trend();
  const RingPrediction prediction = PredictRingErrors(WithoutTrend(hidden, trend), found.variances);
  const Eigen::VectorXd left =
      errors.col(0) - trend * (trend.transpose() * errors.col(0)) - prediction.errors.col(0);
  EXPECT_LT(left.norm() / std::sqrt(double{kRings}), 0.3e-3);
}

TEST(RingErrors, LowerTheCostOfOtherPointsIfTheyAreReal) {
  Random random(4);
  const Eigen::MatrixXd trend = Trend();
  const auto seen = [&](const Eigen::MatrixX2d& errors) {
    return WithoutTrend(Seen(errors, &random), trend);
  };
  const Eigen::MatrixX2d errors = Drawn(2e-3, 1e-4, &random), others = Drawn(2e-3, 1e-4, &random);
  const Eigen::MatrixX2d predicted = PredictRingErrors(seen(errors), {4e-6, 1e-8}).errors;
  EXPECT_GT(GainOfCorrections(seen(errors), predicted), 100.0);
  EXPECT_LT(GainOfCorrections(seen(others), predicted), 0.0);
  // A trend is no gain.
  const Eigen::MatrixX2d along = 0.01 * trend;
  EXPECT_NEAR(GainOfCorrections(seen(errors), along), 0.0, 1e-3);
}

// Rings that were corrected by half of what they err by: what they show counts, whatever its size.
TEST(RingErrors, BeyondCorrectionsAreWhatTheDataShow) {
  Random random(7);
  const Eigen::MatrixX2d errors = Drawn(5e-3, 0.0, &random);
  const Eigen::MatrixXd trend = Trend();
  const RingEquations rings = Seen(errors, &random);
  const auto rms = [](const Eigen::MatrixXd& square) {
    return std::sqrt(square.topLeftCorner(kRings, kRings).trace() / kRings);
  };
  const Eigen::MatrixX2d none = Eigen::MatrixX2d::Zero(kRings, 2);
  EXPECT_NEAR(rms(MeanSquareBeyond(rings, trend, 0.0, none)), 5e-3, 1e-3);
  const RingPrediction best = PredictRingErrors(WithoutTrend(rings, trend), {25e-6, 0.0});
  EXPECT_NEAR(rms(MeanSquareBeyond(rings, trend, 0.0, 0.5 * best.errors)), 2.6e-3, 0.6e-3);
  // What is left then is the trend's, 5 mm * sqrt(2 / 64), and noise.
  EXPECT_NEAR(rms(MeanSquareBeyond(rings, trend, 0.0, best.errors)), 1e-3, 0.3e-3);
}

// Of four parts, each of which sees rings that err by `same` and by `own` of the part, about what all show.
double Scatter(const Eigen::MatrixX2d& same, double own, std::uint64_t seed) {
  Random random(seed);
  std::vector<RingEquations> parts;
  RingEquations all = RingEquations::Zero(kRings);
  for (int part = 0; part < 4; ++part) {
    Eigen::MatrixX2d errors = same + Drawn(own, 0.0, &random);
    errors.col(0) += part * 0.01 * Trend().col(1);  // a trend of its own
    const RingEquations seen = Seen(errors, &random);
    parts.push_back(WithoutTrend(seen, Trend()));
    all.information += seen.information;
    all.gradient += seen.gradient;
  }
  return ScatterOfParts(parts, 2, PredictRingErrors(WithoutTrend(all, Trend()), {25e-6, 9e-8}).errors);
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
