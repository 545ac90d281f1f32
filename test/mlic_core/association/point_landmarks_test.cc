// Landmarks triangulated from tracks, and the noise that each of them is given.
#include "mlic_core/association/point_landmarks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mlic_core/association/landmark_noise.h"
#include "support/synthetic_tracks.h"
#include "support/true_spline.h"

namespace mlic::point_landmarks_test {
namespace {

constexpr double kDegree = M_PI / 180.0;
constexpr double kClaimed = 0.3;  // px

struct Case {
  CalibrationState state;
  TrackSet tracks;
};

// Every other track errs `times` as much as it claims. Points are seen for up to 2 `visible` seconds.
Case MakeCase(double times, double visible = 1.2) {
  Case c;
  const double duration = 10.0;
  const auto trajectory = sim::MakeTrajectory(sim::Scenario::kHandheld, 3, duration, RigidTransform());
  DriveState drive;
  drive.trajectory = TrueSpline(*trajectory, duration, kSyntheticKnots);
  c.state.drives.push_back(drive);
  CameraCalibration camera;
  camera.sensor = {{FromRollPitchYaw(kDegree * Eigen::Vector3d(-91.0, 1.0, -89.0)), {0.06, 0.11, -0.01}},
                   -0.02};
  camera.intrinsics = {
      CameraModel::kPlumbBob, 752, 480, {392.0, 391.0, 371.0, 244.0, -0.09, 0.018, 0.0004, -0.0006, -0.001}};
  c.state.cameras.push_back(camera);
  SyntheticTracksOptions options;
  options.duration = duration;
  options.points = 3000;
  options.visible_seconds = visible;
  c.tracks = MakeTracks(drive.trajectory, c.state.cameras, options);
  Random random(5);
  for (std::size_t t = 0; t < c.tracks.tracks.size(); ++t) {
    for (TrackObservation& o : c.tracks.tracks[t].observations) {
      const double noise = kClaimed * (t % 2 == 0 ? 1.0 : times);
      o.pixel += noise * Eigen::Vector2f(random.Normal(), random.Normal());
      o.sigma = kClaimed;
    }
  }
  return c;
}

double Median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

LandmarkNoise NoiseOf(LandmarkSet landmarks, const Case& c, const LandmarkOptions& made_with) {
  std::vector<DriveTerms> drives(1);
  drives[0].landmarks = std::move(landmarks);
  return MeasureLandmarkNoise(drives, c.state, made_with)[0];
}

// The sigmas that landmarks of at least six observations are given, of what their tracks claim: of even and
// of odd tracks, which are told apart by their pixels.
std::pair<double, double> NoiseGiven(const Case& c, bool of_each) {
  LandmarkOptions options;
  options.noise_of_each = of_each;
  std::vector<double> even, odd;
  TrackSet one;
  one.keyframes = c.tracks.keyframes;
  one.tracks.resize(1);
  for (std::size_t t = 0; t < c.tracks.tracks.size(); ++t) {
    if (c.tracks.tracks[t].observations.size() < 6) continue;
    one.tracks[0] = c.tracks.tracks[t];
    const LandmarkSet set = TriangulateLandmarks(one, c.state, 0, options);
    if (set.points.empty()) continue;
    (t % 2 == 0 ? even : odd).push_back(set.observations[0].sigma / kClaimed);
  }
  EXPECT_GT(std::min(even.size(), odd.size()), 100u);
  return {Median(even), Median(odd)};
}

TEST(Landmarks, AreGivenTheNoiseThatTheirObservationsShow) {
  const auto [even, odd] = NoiseGiven(MakeCase(2.0), true);
  EXPECT_NEAR(even, 1.0, 0.1);
  // Short of two: four degrees of freedom say one, and observations beyond four claimed sigmas are left out.
  EXPECT_GT(odd, 1.35);
  EXPECT_LT(odd, 2.0);
}

TEST(Landmarks, ClaimTheNoiseOfTheirTracksUnlessAsked) {
  const auto [even, odd] = NoiseGiven(MakeCase(2.0), false);
  EXPECT_FLOAT_EQ(even, 1.0);
  EXPECT_FLOAT_EQ(odd, 1.0);
}

// Half of the landmarks err twice as much: with noise of their own they do not make their camera noisier.
TEST(Landmarks, ThatErrMoreDoNotMakeTheirCameraNoisier) {
  const Case c = MakeCase(2.0);
  LandmarkOptions options;
  const auto noise = [&] { return NoiseOf(TriangulateLandmarks(c.tracks, c.state, 0, options), c, options); };
  const LandmarkNoise alike = noise();
  EXPECT_GT(alike.spread, 1.15);
  EXPECT_GT(alike.spread * alike.dependence, 1.25);
  options.noise_of_each = true;
  const LandmarkNoise own = noise();
  EXPECT_LT(own.spread, 1.15);
  EXPECT_LT(own.dependence, 1.1);
}

// A landmark of many observations counts for a dozen, and that is not taken for noise of its camera.
TEST(Landmarks, CountForTwelveObservationsAtMost) {
  const Case c = MakeCase(1.0, 3.0);
  LandmarkOptions options;
  options.noise_of_each = true;
  const LandmarkSet set = TriangulateLandmarks(c.tracks, c.state, 0, options);
  std::vector<double> of_few, of_many;
  for (std::size_t p = 0; p < set.points.size(); ++p) {
    const double observations = static_cast<double>(set.begin[p + 1] - set.begin[p]);
    const double counted = observations * std::pow(kClaimed / set.observations[set.begin[p]].sigma, 2);
    if (observations >= 8.0 && observations <= 12.0) of_few.push_back(counted / observations);
    if (observations > 16.0) of_many.push_back(counted);
  }
  ASSERT_GT(std::min(of_few.size(), of_many.size()), 50u);
  EXPECT_NEAR(Median(of_few), 1.0, 0.1);
  EXPECT_NEAR(Median(of_many), 12.0, 1.0);
  const LandmarkNoise noise = NoiseOf(set, c, options);
  EXPECT_NEAR(noise.spread, 1.0, 0.05);
  EXPECT_NEAR(noise.dependence, 1.0, 0.1);
}

// What the measured noise was made with is taken out again.
TEST(Landmarks, TheirNoiseDoesNotHangOnTheNoiseAssumed) {
  const Case c = MakeCase(1.0);
  for (const LandmarkNoise assumed : {LandmarkNoise{1.0, 1.0}, {1.5, 1.0}, {1.2, 1.6}}) {
    LandmarkOptions options;
    options.noise = {assumed};
    const LandmarkSet set = TriangulateLandmarks(c.tracks, c.state, 0, options);
    EXPECT_NEAR(set.observations[0].sigma, kClaimed * assumed.spread * assumed.dependence, 1e-6);
    const LandmarkNoise noise = NoiseOf(set, c, options);
    EXPECT_NEAR(noise.spread, 1.0, 0.05);
    EXPECT_NEAR(noise.dependence, 1.0, 0.1);
  }
}

}  // namespace
}  // namespace mlic::point_landmarks_test
