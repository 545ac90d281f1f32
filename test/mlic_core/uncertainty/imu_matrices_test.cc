#include "mlic_core/uncertainty/imu_matrices.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mlic_core/common/random.h"
#include "mlic_core/problem/layout.h"
#include "support/lidars_at_rest.h"

namespace mlic::imu_matrices_test {
namespace {

// One LiDAR; a probe that shows every second entry of the IMU's triangles to `shown`, the others not at all.
class ProbedImu : public testing::Test {
 protected:
  ProbedImu() { PlaceAtRest(1, 1, &dataset_, &problem_, &state_); }
  // size: of the errors, beside the noise of the data. imitated: the LiDAR's rotation can look like the first
  // three entries.
  MatrixEvidence Evidence(double size, double shown, std::uint64_t seed, bool imitated = false) const {
    return EvidenceOfMatrices(problem_, state_, Probe(size, shown, seed, imitated), 1.0);
  }
  CalibrationEquations Probe(double size, double shown, std::uint64_t seed, bool imitated = false) const {
    Random random(seed);
    const Layout layout(state_, true);
    CalibrationEquations probe;
    probe.information = Eigen::MatrixXd::Zero(layout.calibration, layout.calibration);
    probe.information.diagonal().setConstant(1e8);
    probe.gradient = probe.prior_gradient = Eigen::VectorXd::Zero(layout.calibration);
    const double information = 1.0 / (shown * shown);
    for (int i = 0; i < Layout::kOfMatrices; ++i) {
      const int at = layout.matrices + i;
      const double error = size * random.Normal() + shown * random.Normal();
      const bool is_shown = imitated ? i < 3 : i % 2 == 0;
      probe.information(at, at) = is_shown ? information : 0.0;
      probe.gradient[at] = is_shown ? -information * error : 0.0;
      if (!imitated || !is_shown) continue;
      probe.information(at, i) = probe.information(i, at) = probe.information(i, i) = information;
      probe.gradient[i] = probe.gradient[at];
    }
    return probe;
  }

  Dataset dataset_;
  JointProblem problem_;
  CalibrationState state_;
};

TEST_F(ProbedImu, WithoutErrorsHasNone) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    EXPECT_FALSE(Evidence(0.0, 1e-3, seed).IsShown()) << "seed " << seed;
  }
}

TEST_F(ProbedImu, WithErrorsHasTheirSize) {
  double sum = 0.0;
  constexpr int kDraws = 20;
  for (std::uint64_t seed = 1; seed <= kDraws; ++seed) {
    const MatrixEvidence evidence = Evidence(5e-3, 3e-4, seed);
    EXPECT_TRUE(evidence.IsShown()) << "seed " << seed;
    sum += evidence.sigma * evidence.sigma;
  }
  EXPECT_NEAR(std::sqrt(sum / kDraws), 5e-3, 1e-3);
}

TEST_F(ProbedImu, WithErrorsThatTheDriveDoesNotShowHasNone) {
  EXPECT_FALSE(Evidence(5e-3, 0.05, 3).IsShown());
}

TEST_F(ProbedImu, WithErrorsThatASensorImitatesHasNone) {
  EXPECT_FALSE(Evidence(5e-3, 3e-4, 3, true).IsShown());
}

// The doubt of held entries is what they err by, in the mean over IMUs, much or little.
TEST_F(ProbedImu, ThatIsHeldAddsWhatItErrsBy) {
  const Layout layout(state_, true);
  for (const double size : {5e-3, 7e-4}) {
    double mean = 0.0;
    constexpr int kDraws = 50;
    for (std::uint64_t seed = 1; seed <= kDraws; ++seed) {
      CalibrationEquations probe = Probe(size, 0.5 * size, seed);
      const double coupling = 0.3 * probe.information(layout.matrices, layout.matrices);
      probe.information(0, layout.matrices) = probe.information(layout.matrices, 0) = coupling;
      const Eigen::MatrixXd scatter = ScatterOfMatrices(problem_, state_, probe, 1.0);
      EXPECT_EQ(scatter.rows(), Layout(state_, false).calibration);
      EXPECT_EQ(scatter.trace(), scatter(0, 0));
      mean += scatter(0, 0) / (coupling * coupling) / kDraws;
    }
    EXPECT_NEAR(std::sqrt(mean), size, 0.3 * size);
  }
}

// What a drive does not show of an entry it has of others, which are small here, not of data sheets alone.
TEST_F(ProbedImu, ThatIsGoodAddsLittle) {
  const Layout layout(state_, true);
  const int hidden = layout.matrices + 1;
  const auto doubt = [&](double size, double shown) {
    CalibrationEquations probe = Probe(size, shown, 5);
    probe.information(0, hidden) = probe.information(hidden, 0) = 1.0;
    return std::sqrt(ScatterOfMatrices(problem_, state_, probe, 1.0)(0, 0));
  };
  EXPECT_LT(doubt(0.0, 1e-5), 3e-4);
  EXPECT_GT(doubt(0.0, 1.0), 3e-3);
  EXPECT_LT(doubt(0.0, 1.0), 0.02);
}

TEST_F(ProbedImu, ThatIsFarOffHasAFiniteDoubt) {
  EXPECT_TRUE(ScatterOfMatrices(problem_, state_, Probe(0.02, 1e-6, 3), 1.0).allFinite());
}

TEST_F(ProbedImu, ThatWasNotProbedHasNone) {
  EXPECT_FALSE(EvidenceOfMatrices(problem_, state_, {}, 1.0).IsShown());
  EXPECT_TRUE(ScatterOfMatrices(problem_, state_, {}, 1.0).isZero());
}

}  // namespace
}  // namespace mlic::imu_matrices_test
