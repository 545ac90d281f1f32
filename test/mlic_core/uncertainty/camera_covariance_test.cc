// Sigmas of cameras whose landmarks are weighed by their own observations, and whose observations share
// errors.
#include "mlic_core/uncertainty/camera_covariance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "mlic_core/common/random.h"
#include "mlic_core/problem/joint_solver.h"
#include "mlic_core/problem/layout.h"
#include "mlic_core/uncertainty/observability.h"
#include "support/camera_with_imu.h"

namespace mlic::camera_covariance_test {
namespace {

// Intrinsics' errors in their sigmas, as claimed and with the inflation, after rounds of landmarks and solve.
struct Outcome {
  CameraInflation inflation;
  Eigen::VectorXd claimed, inflated;
  Layout layout;
  Eigen::VectorXd intrinsics;
  Eigen::MatrixXd covariance;  // of the calibration, as claimed
};

Outcome Calibrate(const CameraWithImu& c, bool noise_of_each) {
  CalibrationState state = c.state;
  JointProblem problem;
  problem.dataset = &c.dataset;
  problem.cameras.resize(state.cameras.size());
  for (std::size_t d = 0; d < c.tracks.size(); ++d) problem.drives.emplace_back().imu_sigma = {c.imu_sigma};
  LandmarkOptions options;
  options.noise_of_each = noise_of_each;
  options.noise.resize(state.cameras.size());
  SolveSummary summary;
  for (int round = 0; round < (noise_of_each ? 6 : 2); ++round) {
    for (std::size_t d = 0; d < c.tracks.size(); ++d) {
      problem.drives[d].landmarks = TriangulateLandmarks(c.tracks[d], state, d, options);
    }
    summary = SolveJointProblem(problem, 4, CancellationToken(), &state);
    PlaceLandmarks(std::move(summary.landmarks), &problem);
  }
  const ObservabilityAnalysis plain = AnalyzeCalibration(problem, state, summary.information);
  CameraInflation inflation = MeasureCameraInflation({problem, state}, options, plain.solved_covariance);
  const ObservabilityAnalysis inflated =
      AnalyzeCalibration(problem, state, summary.information, Inflation{inflation, {}});
  const std::vector<double>&found = state.cameras[0].intrinsics.parameters,
        &truth = c.state.cameras[0].intrinsics.parameters;
  Eigen::VectorXd a(found.size()), b(found.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    a[i] = (found[i] - truth[i]) / plain.cameras[0].sigmas[i];
    b[i] = (found[i] - truth[i]) / inflated.cameras[0].sigmas[i];
  }
  return {inflation,
          a,
          b,
          Layout(state, false),
          Eigen::Map<const Eigen::VectorXd>(found.data(), static_cast<Eigen::Index>(found.size())),
          plain.solved_covariance};
}

// Claimed sigmas are too small by a fifth (60 seeds: 1.40 and 0.80).
TEST(CameraInflation, LandmarksWeighedByTheirOwnObservationsSayLessThanTheirWeights) {
  constexpr int kSeeds = 16;
  double claimed = 0.0, inflated = 0.0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const Outcome outcome = Calibrate(MakeCameraWithImu(seed, 1500, NoCommonError), true);
    claimed += outcome.claimed.squaredNorm() / (kSeeds * outcome.claimed.size());
    inflated += outcome.inflated.squaredNorm() / (kSeeds * outcome.inflated.size());
  }
  std::printf("mean square of errors in claimed sigmas %.2f, with the inflation %.2f\n", claimed, inflated);
  EXPECT_LT(inflated, 0.8 * claimed);
  EXPECT_GT(inflated, 0.5);
  EXPECT_LT(inflated, 1.2);
}

TEST(CameraInflation, IsSmallWhereErrorsAreWhite) {
  const Outcome outcome = Calibrate(MakeCameraWithImu(3, 3000, NoCommonError), false);
  EXPECT_EQ(outcome.inflation.self_weighing.squaredNorm(), 0.0);
  EXPECT_GE(outcome.inflation.growth.minCoeff(), 1.0);
  EXPECT_LT(outcome.inflation.growth.maxCoeff(), 1.4);
}

// The image grows and shrinks from stretch to stretch, as if the focal length did.
TEST(CameraInflation, SeesErrorsThatObservationsOfTheSameSecondsShare) {
  const auto breathing = [](double time, const Eigen::Vector2d& pixel) -> Eigen::Vector2d {
    Random random(static_cast<std::uint64_t>(time / 3.0) + 7);
    return 3e-3 * random.Normal() * (pixel - Eigen::Vector2d(371.0, 244.0));
  };
  const Outcome white = Calibrate(MakeCameraWithImu(3, 3000, NoCommonError), false);
  const Outcome outcome = Calibrate(MakeCameraWithImu(3, 3000, breathing), false);
  const int lens = outcome.layout.Intrinsics(0);
  EXPECT_GT(outcome.inflation.growth[lens], 1.3 * white.inflation.growth[lens]);
  EXPECT_LT(std::abs(outcome.inflated[0]), 0.7 * std::abs(outcome.claimed[0]));
}

// The image leans to the left and to the right by turns, as it does where the rows are read more slowly or
// faster.
TEST(CameraInflation, ReadoutHasAFactorOfItsOwn) {
  const auto leaning = [](double time, const Eigen::Vector2d& pixel) -> Eigen::Vector2d {
    Random random(static_cast<std::uint64_t>(time / 3.0) + 7);
    return {3e-3 * random.Normal() * (pixel.y() - 244.0), 0.0};
  };
  constexpr double kReadout = 0.02;
  const Outcome outcome = Calibrate(MakeCameraWithImu(3, 3000, leaning, kReadout), false);
  const int lens = outcome.layout.Intrinsics(0);
  const double of_lens = outcome.inflation.growth.segment(lens, outcome.intrinsics.size()).maxCoeff();
  std::printf("growth of the readout %.2f, of the lens %.2f\n",
              outcome.inflation.growth[outcome.layout.Readout(0)], of_lens);
  EXPECT_GT(outcome.inflation.growth[outcome.layout.Readout(0)], 1.5 * of_lens);
}

// The second camera leans away from the first and back, from stretch to stretch.
TEST(CameraInflation, SeesWhatTwoCamerasShareOfTheirRelation) {
  CameraCalibration other = CameraOfCameraWithImu();
  other.sensor.T_imu_sensor.rotation = other.sensor.T_imu_sensor.rotation * ExpQuaternion({0.0, 0.3, 0.0});
  other.sensor.T_imu_sensor.translation.x() += 0.2;
  const CameraWithImu steady = MakeCamerasWithImu({CameraOfCameraWithImu(), other}, 3, 3000, NoCommonError);
  CameraWithImu leaning = steady;
  for (Track& track : leaning.tracks[0].tracks) {
    for (TrackObservation& o : track.observations) {
      const Keyframe& keyframe = leaning.tracks[0].keyframes[o.keyframe];
      if (keyframe.camera == 0) continue;
      Random random(static_cast<std::uint64_t>(keyframe.time / 3.0) + 7);
      o.pixel.x() += static_cast<float>(2.0 * random.Normal());
    }
  }
  const Outcome white = Calibrate(steady, false), outcome = Calibrate(leaning, false);
  ASSERT_EQ(outcome.inflation.relations.size(), 3u);
  const CameraInflation::Relation& rotation = outcome.inflation.relations[0];
  std::printf(
      "growth of the relation: rotation %.2f, of white errors %.2f; of the cameras' rotations %.2f, %.2f\n",
      rotation.growth, white.inflation.relations[0].growth,
      outcome.inflation.growth[outcome.layout.Camera(0)], outcome.inflation.growth[outcome.layout.Camera(1)]);
  EXPECT_GT(rotation.growth, 1.3 * white.inflation.relations[0].growth);
  CameraInflation relations = outcome.inflation;
  relations.growth.setOnes();
  relations.self_weighing.setZero();
  relations.pattern.setZero();
  const Eigen::MatrixXd added = VarianceOfInflation(outcome.covariance, relations, 1.0);
  const Eigen::MatrixXd of_tracks = outcome.covariance * relations.information * outcome.covariance;
  for (Eigen::Index i = 0; i < 3; ++i) {
    const Eigen::VectorXd direction = rotation.directions.row(i);
    EXPECT_GE(direction.dot((of_tracks + added) * direction),
              0.999 * std::pow(rotation.growth, 2) * direction.dot(of_tracks * direction));
  }
}

// Polynomials over the image up to the third order, of a mean square of one over it.
std::array<double, 10> OrthonormalPatterns(const Eigen::Vector2d& pixel) {
  const double x = (pixel.x() - 371.0) / 371.0, y = (pixel.y() - 244.0) / 244.0;
  const auto legendre = [](double t) {
    return std::array<double, 4>{1.0, std::sqrt(3.0) * t, std::sqrt(5.0) * 0.5 * (3.0 * t * t - 1.0),
                                 std::sqrt(7.0) * 0.5 * (5.0 * t * t - 3.0) * t};
  };
  const std::array<double, 4> of_x = legendre(x), of_y = legendre(y);
  std::array<double, 10> patterns{};
  std::size_t next = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t k = 0; i + k < 4; ++k) patterns[next++] = of_x[i] * of_y[k];
  }
  return patterns;
}

// Errors with one pattern over all images do not show, but move the calibration as the inflation says.
TEST(CameraInflation, HasTheDoubtOfAPatternOverTheImage) {
  constexpr int kDraws = 16;
  constexpr double kSize = 0.1;  // px, rms
  const Outcome without = Calibrate(MakeCameraWithImu(3, 3000, NoCommonError), false);
  const Eigen::MatrixXd expected = without.covariance * without.inflation.pattern * without.covariance /
                                   std::pow(without.inflation.pattern_errors[0], 2);
  const int lens = without.layout.Intrinsics(0);
  double squares = 0.0;
  Random random(5);
  for (int draw = 0; draw < kDraws; ++draw) {
    std::array<Eigen::Vector2d, 10> size;
    for (Eigen::Vector2d& s : size) {
      s = kSize / std::sqrt(20.0) * Eigen::Vector2d(random.Normal(), random.Normal());
    }
    const auto pattern = [&](double, const Eigen::Vector2d& pixel) -> Eigen::Vector2d {
      const std::array<double, 10> patterns = OrthonormalPatterns(pixel);
      Eigen::Vector2d error = Eigen::Vector2d::Zero();
      for (std::size_t i = 0; i < size.size(); ++i) error += patterns[i] * size[i];
      return error;
    };
    const Outcome with = Calibrate(MakeCameraWithImu(3, 3000, pattern), false);
    for (int i = 0; i < 4; ++i) {
      const double moved = with.intrinsics[i] - without.intrinsics[i];
      squares += moved * moved / (kSize * kSize * expected(lens + i, lens + i));
    }
  }
  std::printf("mean square of the shifts, in what is expected: %.2f\n", squares / (4 * kDraws));
  EXPECT_GT(squares / (4 * kDraws), 0.6);
  EXPECT_LT(squares / (4 * kDraws), 1.6);
}

// That of a pattern which no lens has is what the image is seen to have.
TEST(CameraInflation, MeasuresThePatternOverTheImage) {
  const CameraInflation none = Calibrate(MakeCameraWithImu(3, 3000, NoCommonError), false).inflation;
  EXPECT_LT(none.pattern_errors[0], 0.03);
  constexpr double kSize = 0.1;  // px, rms of both coordinates
  const auto waves = [&](double, const Eigen::Vector2d& pixel) -> Eigen::Vector2d {
    const double phase = 2.0 * M_PI / 250.0;
    return kSize * Eigen::Vector2d(std::sin(phase * pixel.y()), std::sin(phase * pixel.x()));
  };
  const CameraInflation seen = Calibrate(MakeCameraWithImu(3, 3000, waves), false).inflation;
  EXPECT_GT(seen.pattern_errors[0], 0.04);
  EXPECT_LT(seen.pattern_errors[0], 0.1);
  EXPECT_GT(seen.pattern.trace(), 4.0 * none.pattern.trace());
}

}  // namespace
}  // namespace mlic::camera_covariance_test
