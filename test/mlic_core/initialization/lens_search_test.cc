#include "mlic_core/initialization/lens_search.h"

#include <gtest/gtest.h>

#include "mlic_core/initialization/camera_on_trajectory.h"
#include "support/synthetic_tracks.h"
#include "support/true_spline.h"

namespace mlic::lens_search_test {
namespace {

constexpr double kDegree = M_PI / 180.0;

CameraIntrinsics PlumbBob(double f, double k1, double k2, double k3) {
  return {CameraModel::kPlumbBob, 752, 480, {f, 0.998 * f, 367.2, 248.4, k1, k2, 0.0002, -0.0003, k3}};
}
CameraIntrinsics Wide() {
  return {CameraModel::kRationalPolynomial,
          800,
          600,
          {360.4, 360.9, 404.2, 294.3, 0.8127, 0.0918, 0.0001, -0.0002, 0.0021, 1.0871, 0.3127, 0.0068}};
}
CameraIntrinsics Fisheye() {
  return {
      CameraModel::kEquidistant, 720, 720, {206.0, 206.4, 363.7, 355.4, 0.0132, -0.0051, 0.0021, -0.0006}};
}
CameraIntrinsics DoubleSphere() {
  return {CameraModel::kDoubleSphere, 720, 720, {194.5, 194.1, 356.8, 362.6, -0.1812, 0.5921}};
}

double FieldOfViewDeg(const CameraIntrinsics& lens) {
  Eigen::Vector3d left, right;
  EXPECT_TRUE(Unproject(lens, {-0.5, lens.parameters[3]}, &left));
  EXPECT_TRUE(Unproject(lens, {lens.width - 0.5, lens.parameters[3]}, &right));
  return (std::atan2(right.x(), right.z()) - std::atan2(left.x(), left.z())) / kDegree;
}

// A hand-held drive of one camera with this lens; 0.5 px of noise, every twentieth observation wrong.
struct Drive {
  CameraCalibration truth;
  CalibrationState state;
  std::vector<TrackSet> tracks;

  explicit Drive(const CameraIntrinsics& lens, int points = 6000) {
    truth.sensor.T_imu_sensor = {FromRollPitchYaw(Eigen::Vector3d(-91.3, 1.1, -88.9) * kDegree),
                                 Eigen::Vector3d(0.061, 0.108, -0.013)};
    truth.sensor.time_offset = -0.0085;
    truth.intrinsics = lens;
    SyntheticTracksOptions options;
    options.duration = 20.0;
    options.noise = 0.5;
    options.outliers = 0.05;
    options.points = points;
    const auto motion = sim::MakeTrajectory(sim::Scenario::kHandheld, 1, options.duration, RigidTransform());
    state.drives.emplace_back();
    state.drives[0].trajectory = TrueSpline(*motion, options.duration, kSyntheticKnots);
    tracks = {MakeTracks(state.drives[0].trajectory, {truth}, options)};
  }

  CameraInitialization From(const CameraStart& start) const {
    return InitializeCameras(RigOf({truth}), {start}, tracks, state, CancellationToken());
  }
};

// From the field of view alone the initialisation ends where it ends from the true lens: what is left is the
// noise of the tracks.
void ExpectToStart(const CameraIntrinsics& lens, const std::vector<double>& field_of_view_errors,
                   int points = 6000) {
  const Drive drive(lens, points);
  const CameraInitialization from_truth = drive.From({lens, false});
  ASSERT_TRUE(from_truth.found[0]);
  EXPECT_LT(MeanDisplacement(lens, from_truth.cameras[0].intrinsics), 1.0);
  for (const double error : field_of_view_errors) {
    const CameraInitialization result = drive.From(
        {IntrinsicsFromFieldOfView(lens.model, lens.width, lens.height, FieldOfViewDeg(lens) * error), true});
    for (const SensorProblem& problem : result.problems) std::printf("  %s\n", problem.reason.c_str());
    ASSERT_TRUE(result.found[0]) << "field of view times " << error;
    const CameraCalibration &expected = from_truth.cameras[0], &found = result.cameras[0];
    EXPECT_LT(AngleBetween(found.sensor.T_imu_sensor.rotation, expected.sensor.T_imu_sensor.rotation),
              0.01 * kDegree)
        << error;
    EXPECT_LT(MeanDisplacement(expected.intrinsics, found.intrinsics), 0.1) << error;
    EXPECT_NEAR(found.sensor.time_offset, expected.sensor.time_offset, 2e-5) << error;
  }
}

TEST(LensSearch, StartsAPinholeOfStrongBarrelDistortion) {
  ExpectToStart(PlumbBob(618.3, -0.4513, 0.2712, -0.0811), {1.0});
}
TEST(LensSearch, StartsAnOrdinaryPinhole) {
  ExpectToStart(PlumbBob(458.6, -0.2834, 0.0740, 0.0), {0.87, 1.0, 1.15});
}
TEST(LensSearch, StartsAPinholeOfLittleDistortion) {
  ExpectToStart(PlumbBob(421.5, -0.1507, 0.0314, -0.0019), {1.0});
}
TEST(LensSearch, StartsAPinholeOfPincushionDistortion) {
  ExpectToStart(PlumbBob(501.7, 0.0508, -0.0213, 0.0011), {1.0});
}
TEST(LensSearch, StartsAWideLens) { ExpectToStart(Wide(), {0.87, 1.15}, 3000); }
TEST(LensSearch, StartsAFisheye) { ExpectToStart(Fisheye(), {0.87, 1.15}, 1500); }
TEST(LensSearch, StartsADoubleSphere) { ExpectToStart(DoubleSphere(), {1.0}); }

TEST(LensSearch, FindsNothingInImagesOfAnotherDrive) {
  const Drive drive(PlumbBob(458.6, -0.2834, 0.0740, 0.0));
  const auto other = sim::MakeTrajectory(sim::Scenario::kHandheld, 2, 20.0, RigidTransform());
  const SplitSpline spline = TrueSpline(*other, 20.0, kSyntheticKnots);
  const CameraIntrinsics start = IntrinsicsFromFieldOfView(CameraModel::kPlumbBob, 752, 480, 93.0);
  EXPECT_FALSE(SearchLens(MatchesOfKeyframes(drive.tracks, 0), {&spline}, {start, {}, {}, {}}));
}

}  // namespace
}  // namespace mlic::lens_search_test
