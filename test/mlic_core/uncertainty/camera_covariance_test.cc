// Sigmas of cameras whose landmarks are weighed by their own observations, and whose observations share
// errors.
#include "mlic_core/uncertainty/camera_covariance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>

#include "mlic_core/problem/joint_solver.h"
#include "mlic_core/problem/layout.h"
#include "mlic_core/uncertainty/observability.h"
#include "support/synthetic_tracks.h"
#include "support/true_spline.h"

namespace mlic {
namespace {

constexpr double kDegree = M_PI / 180.0;
constexpr double kDuration = 18.0, kImuRate = 200.0;
constexpr double kGyroscope = 2e-4, kAccelerometer = 2e-3;  // densities
constexpr double kPixel = 0.3;                              // px

CameraCalibration TrueCamera() {
  CameraCalibration camera;
  camera.sensor = {{FromRollPitchYaw(kDegree * Eigen::Vector3d(-91.0, 1.0, -89.0)), {0.06, 0.11, -0.01}},
                   -0.02};
  camera.intrinsics = {
      CameraModel::kPlumbBob, 752, 480, {392.0, 391.0, 371.0, 244.0, -0.09, 0.018, 0.0004, -0.0006, -0.001}};
  return camera;
}

// An error of an observation that is not white, px, by its time and pixel.
using CommonError = std::function<Eigen::Vector2d(double, const Eigen::Vector2d&)>;

struct Case {
  Dataset dataset;
  CalibrationState state;  // at the truth
  std::vector<TrackSet> tracks;
};

Case MakeCase(std::uint64_t seed, int points, const CommonError& common) {
  Case c;
  const auto trajectory = sim::MakeTrajectory(sim::Scenario::kHandheld, seed, kDuration, RigidTransform());
  DriveState drive;
  drive.trajectory = TrueSpline(*trajectory, kDuration, kSyntheticKnots);
  c.state.drives.push_back(drive);
  c.state.cameras.push_back(TrueCamera());
  SyntheticTracksOptions options;
  options.duration = kDuration;
  options.points = points;
  options.seed = seed;
  options.visible_seconds = 0.8;
  c.tracks.push_back(MakeTracks(drive.trajectory, c.state.cameras, options));
  Random random(seed + 50);
  for (Track& track : c.tracks[0].tracks) {
    for (TrackObservation& o : track.observations) {
      const double time = c.tracks[0].keyframes[o.keyframe].time;
      o.pixel += common(time, o.pixel.cast<double>()).cast<float>() +
                 kPixel * Eigen::Vector2f(random.Normal(), random.Normal());
      o.sigma = kPixel;
    }
  }
  c.dataset.drives.emplace_back();
  const auto noise = [&](double density) {
    const double x = random.Normal(), y = random.Normal(), z = random.Normal();
    return Eigen::Vector3d(density * std::sqrt(kImuRate) * Eigen::Vector3d(x, y, z));
  };
  for (int i = 0; i <= static_cast<int>(kDuration * kImuRate); ++i) {
    const double t = i / kImuRate;
    const SplineBasis basis(drive.trajectory.position.knots(), t);
    c.dataset.drives[0].imu.push_back({t, drive.trajectory.rotation.AngularVelocity(t) + noise(kGyroscope),
                                       drive.trajectory.rotation.Rotation(t).conjugate() *
                                               (drive.trajectory.position.Acceleration(basis) - kGravity) +
                                           noise(kAccelerometer)});
  }
  return c;
}

// Intrinsics' errors in their sigmas, as claimed and with the inflation, after rounds of landmarks and solve.
struct Outcome {
  CameraInflation inflation;
  Eigen::VectorXd claimed, inflated;
  Layout layout;
};

Outcome Calibrate(const Case& c, bool noise_of_each) {
  CalibrationState state = c.state;
  JointProblem problem;
  problem.dataset = &c.dataset;
  ImuSigma sigma;
  sigma.gyroscope.setConstant(kGyroscope * std::sqrt(kImuRate));
  sigma.accelerometer.setConstant(kAccelerometer * std::sqrt(kImuRate));
  problem.cameras.resize(1);
  for (std::size_t d = 0; d < c.tracks.size(); ++d) problem.drives.emplace_back().imu_sigma = sigma;
  LandmarkOptions options;
  options.noise_of_each = noise_of_each;
  options.noise.resize(1);
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
  return {inflation, a, b, Layout(state, false)};
}

Eigen::Vector2d None(double, const Eigen::Vector2d&) { return Eigen::Vector2d::Zero(); }

// Claimed sigmas are too small by a fifth (60 seeds: 1.40 and 0.80).
TEST(CameraInflation, LandmarksWeighedByTheirOwnObservationsSayLessThanTheirWeights) {
  constexpr int kSeeds = 16;
  double claimed = 0.0, inflated = 0.0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const Outcome outcome = Calibrate(MakeCase(seed, 1500, None), true);
    claimed += outcome.claimed.squaredNorm() / (kSeeds * outcome.claimed.size());
    inflated += outcome.inflated.squaredNorm() / (kSeeds * outcome.inflated.size());
  }
  std::printf("mean square of errors in claimed sigmas %.2f, with the inflation %.2f\n", claimed, inflated);
  EXPECT_LT(inflated, 0.8 * claimed);
  EXPECT_GT(inflated, 0.5);
  EXPECT_LT(inflated, 1.2);
}

TEST(CameraInflation, IsSmallWhereErrorsAreWhite) {
  const Outcome outcome = Calibrate(MakeCase(3, 3000, None), false);
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
  const Outcome white = Calibrate(MakeCase(3, 3000, None), false);
  const Outcome outcome = Calibrate(MakeCase(3, 3000, breathing), false);
  const int lens = outcome.layout.Intrinsics(0);
  EXPECT_GT(outcome.inflation.growth[lens], 1.3 * white.inflation.growth[lens]);
  EXPECT_LT(std::abs(outcome.inflated[0]), 0.7 * std::abs(outcome.claimed[0]));
}

}  // namespace
}  // namespace mlic
