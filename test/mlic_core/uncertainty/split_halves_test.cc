#include "mlic_core/uncertainty/split_halves.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mlic_core/association/landmark_noise.h"
#include "mlic_core/association/point_landmarks.h"
#include "mlic_core/common/significance.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/problem/joint_solver.h"
#include "mlic_core/uncertainty/observability.h"
#include "support/camera_with_imu.h"

namespace mlic::split_halves_test {
namespace {

// Values of tables of the distributions.
TEST(Significance, OfSumsOfSquaresIsThatOfOneNormalVariable) {
  EXPECT_NEAR(EquivalentDeviation(9.0, 1), 3.0, 1e-6);
  EXPECT_NEAR(EquivalentDeviation(13.816, 2), 3.2905, 1e-3);  // p = 0.001
  EXPECT_NEAR(EquivalentDeviation(16.266, 3), 3.2905, 1e-3);
  EXPECT_NEAR(EquivalentDeviation(34.528, 13), 3.2905, 1e-3);
  EXPECT_NEAR(EquivalentDeviation(1e4, 1), 100.0, 0.01);
  EXPECT_NEAR(EquivalentDeviation(0.0, 3), 0.0, 1e-9);
  for (const double squares : {599.0, 601.0}) {  // on either side of the far tail
    EXPECT_NEAR(EquivalentDeviation(squares, 4), 24.12, 0.04);
  }
}

TEST(Significance, OfSigmasThatAreInDoubtIsStudents) {
  EXPECT_NEAR(StudentDeviation(0.05, 10), 2.2281, 1e-3);
  EXPECT_NEAR(StudentDeviation(0.001, 20), 3.8495, 1e-3);
}

DriveState TurningFrom(double begin, double end) {
  constexpr double kSpacing = 0.1, kRate = 0.5, kDuration = 20.0;
  const UniformKnots knots = UniformKnots::Covering(0.0, kDuration, kSpacing);
  std::vector<Eigen::Quaterniond> rotations;
  for (int k = 0; k < knots.count; ++k) {
    const double time = std::clamp(knots.ControlPointTime(k), begin, end);
    rotations.push_back(ExpQuaternion({0.0, 0.0, kRate * (time - begin)}));
  }
  DriveState drive;
  drive.trajectory.rotation = So3Spline(knots, rotations);
  drive.trajectory.position =
      PositionSpline(knots, std::vector<Eigen::Vector3d>(knots.count, Eigen::Vector3d::Zero()));
  return drive;
}

TEST(CutByTurning, LeavesHalfOfTheTurningOnEitherSide) {
  CalibrationState state;
  state.drives = {TurningFrom(12.0, 18.0)};
  const Halves halves = CutByTurning(state, 0.5);
  ASSERT_EQ(halves.first.size(), 1u);
  EXPECT_EQ(halves.first[0].start, 0.0);
  EXPECT_NEAR(halves.first[0].end, 15.0, 0.1);
  EXPECT_EQ(halves.second[0].start, halves.first[0].end);
  EXPECT_EQ(halves.second[0].end, 20.0);
}

TEST(CutByTurning, LeavesWholeDrivesTogether) {
  CalibrationState state;
  state.drives = {TurningFrom(0.0, 4.0), TurningFrom(0.0, 20.0), TurningFrom(19.0, 20.0)};
  const Halves halves = CutByTurning(state, 0.5);
  EXPECT_EQ(halves.first[0].Duration(), 20.0);
  EXPECT_EQ(halves.second[0].Duration(), 0.0);
  EXPECT_NEAR(halves.first[1].end, 8.5, 0.1);
  EXPECT_EQ(halves.first[2].Duration(), 0.0);
  EXPECT_EQ(halves.second[2].Duration(), 20.0);
}

// Rounds of landmarks and solve, as the joint calibration's, of a camera that turns by so much when this
// share of the drive is over.
Adjustment AdjustLoose(double degrees, double share, CameraWithImu* c) {
  const CameraIntrinsics lens = CameraOfCameraWithImu().intrinsics;
  const Eigen::Matrix3d turn = ExpMatrix(M_PI / 180.0 * degrees * Eigen::Vector3d::UnitY());
  *c = MakeCameraWithImu(2, 2000, [&](double time, const Eigen::Vector2d& pixel) -> Eigen::Vector2d {
    Eigen::Vector3d bearing;
    Eigen::Vector2d turned;
    if (time < share * kCameraWithImuDuration || !Unproject(lens, pixel, &bearing) ||
        !Project(lens, turn * bearing, &turned)) {
      return Eigen::Vector2d::Zero();
    }
    return turned - pixel;
  });
  Adjustment adjustment;
  adjustment.state = c->state;
  JointProblem& problem = adjustment.problem;
  problem.dataset = &c->dataset;
  problem.cameras.resize(1);
  problem.drives.emplace_back().imu_sigma = {c->imu_sigma};
  adjustment.given_imu_sigma = {c->imu_sigma};
  adjustment.cameras.found = {true};
  adjustment.cameras.tracks = c->tracks;
  adjustment.rounds.landmarks = Landmarks::kTracks;
  LandmarkOptions& options = adjustment.cameras.landmark_options;
  options.noise_of_each = true;
  options.largest_error = 8.0;
  options.noise.resize(1);
  for (int round = 0; round < 6; ++round) {
    if (round > 0) options.noise = MeasureLandmarkNoise(problem.drives, adjustment.state, options);
    problem.drives[0].landmarks = TriangulateLandmarks(c->tracks[0], adjustment.state, 0, options);
    adjustment.last_solve = SolveJointProblem(problem, 6, CancellationToken(), &adjustment.state);
    PlaceLandmarks(std::move(adjustment.last_solve.landmarks), &problem);
  }
  adjustment.scale.inflation.cameras = MeasureCameraInflation(
      {problem, adjustment.state}, options,
      AnalyzeCalibration(problem, adjustment.state, adjustment.last_solve.information).solved_covariance);
  return adjustment;
}

std::vector<SensorHalves> HalvesOfLoose(double degrees, double share) {
  CameraWithImu c;
  const Adjustment adjustment = AdjustLoose(degrees, share, &c);
  std::vector<SensorHalves> halves = CompareHalves(adjustment, c.dataset, CancellationToken());
  for (const SensorHalves& sensor : halves) std::printf("%.1f deg: %s\n", degrees, Describe(sensor).c_str());
  return halves;
}

TEST(CompareHalves, OfAFirmCameraAgree) {
  const std::vector<SensorHalves> halves = HalvesOfLoose(0.0, 0.5);
  ASSERT_EQ(halves.size(), 1u);
  EXPECT_EQ(halves[0].quantities.size(), 4u);
  EXPECT_LT(WorstOf(halves[0]), LargestByChance(halves));
}

// They see the images where the whole drive's solve did.
TEST(CompareHalves, OfACameraWhoseStampsWanderAgree) {
  CameraWithImu c;
  Adjustment adjustment = AdjustLoose(0.0, 0.5, &c);
  const std::vector<SensorHalves> on_time = CompareHalves(adjustment, c.dataset, CancellationToken());
  StampCourse course;
  for (Keyframe& keyframe : adjustment.cameras.tracks[0].keyframes) {
    const double shift = 5e-3 * std::sin(3.0 * keyframe.time);
    keyframe.time -= shift;
    course.times.push_back(keyframe.time);
    course.shifts.push_back(shift);
  }
  adjustment.cameras.stamp_courses = {{course}};
  const std::vector<SensorHalves> followed = CompareHalves(adjustment, c.dataset, CancellationToken());
  ASSERT_EQ(followed.size(), 1u);
  EXPECT_NEAR(WorstOf(followed[0]), WorstOf(on_time[0]), 1e-3);
}

// A translation that stands at the guess is not the data's, however still the solve keeps it.
TEST(CompareHalves, OfWhatIsHeldAtTheGuessAreNotCompared) {
  CameraWithImu c;
  Adjustment adjustment = AdjustLoose(0.0, 0.5, &c);
  JointProblem& problem = adjustment.problem;
  ExtrinsicGuess guess;
  guess.T_imu_sensor = adjustment.state.cameras[0].sensor.T_imu_sensor;
  guess.sigma_rotation.setConstant(1.0);
  guess.sigma_translation = {1.0, 1.0, 1e-4};  // m: better than the data say
  problem.cameras[0].guess = guess;
  const Layout layout(adjustment.state, false);
  Eigen::VectorXd row = Eigen::VectorXd::Zero(layout.poses);
  row[layout.Camera(0) + 5] = 1.0;
  problem.held_translations = {row};
  const std::vector<SensorHalves> halves = CompareHalves(adjustment, c.dataset, CancellationToken());
  ASSERT_EQ(halves.size(), 1u);
  const HalvesDifference& translation = halves[0].quantities[1];
  EXPECT_EQ(translation.directions, 2);
  ASSERT_EQ(translation.sigma.size(), 3u);
  EXPECT_GT(translation.sigma[0], 0.0);
  EXPECT_EQ(translation.sigma[2], 0.0);
}

// The calibration sides with one half, and what it makes of the other's landmarks tells less and less of it.
TEST(CompareHalves, OfACameraThatComesLooseDiffer) {
  for (const double degrees : {1.0, 3.0}) {
    const std::vector<SensorHalves> halves = HalvesOfLoose(degrees, 0.5);
    ASSERT_EQ(halves.size(), 1u);
    EXPECT_GT(WorstOf(halves[0]), 1.5 * LargestByChance(halves)) << degrees;
    const HalvesDifference& rotation = halves[0].quantities[0];
    ASSERT_EQ(rotation.difference.size(), 3u);
    const double turned =
        Eigen::Vector3d(rotation.difference[0], rotation.difference[1], rotation.difference[2]).norm() *
        180.0 / M_PI;
    EXPECT_NEAR(turned, degrees, 0.1 * degrees);
  }
}

TEST(GrowthOfSigmas, IsWhatTheDifferencesAddToTwentySquares) {
  HalvesDifference difference;
  difference.directions = 3;
  difference.squares = 1.0;
  EXPECT_EQ(GrowthOfSigmas(difference), 1.0);
  difference.squares = 33.0;
  EXPECT_NEAR(GrowthOfSigmas(difference), std::sqrt(53.0 / 23.0), 1e-12);
}

// Differences that chance allows widen what is claimed; a sensor that is not given widens nothing.
TEST(GrowthOfSigmas, IsInThoseOfTheCalibration) {
  CameraWithImu c;
  Adjustment adjustment = AdjustLoose(0.0, 0.5, &c);
  const ObservabilityAnalysis before = Analyze(adjustment, c.dataset);
  HalvesDifference translation, lens;
  translation.quantity = HalvesDifference::Quantity::kTranslation;
  translation.directions = 3;
  translation.squares = 33.0;
  lens.quantity = HalvesDifference::Quantity::kIntrinsics;
  lens.directions = 5;
  lens.squares = 15.0;
  SensorHalves halves;
  halves.quantities = {translation, lens};
  adjustment.halves = {halves};
  const ObservabilityAnalysis after = Analyze(adjustment, c.dataset);
  const double of_translation = 53.0 / 23.0, of_lens = 35.0 / 25.0;
  const int pose = Layout::Sensor(0);
  EXPECT_NEAR(after.covariance(pose + 4, pose + 4) / before.covariance(pose + 4, pose + 4), of_translation,
              1e-9);
  EXPECT_NEAR(after.covariance(pose + 4, pose + 1) / before.covariance(pose + 4, pose + 1),
              std::sqrt(of_translation), 1e-9);
  EXPECT_NEAR(std::pow(after.sigmas[0].translation[2] / before.sigmas[0].translation[2], 2), of_translation,
              1e-9);
  EXPECT_EQ(after.sigmas[0].rotation, before.sigmas[0].rotation);
  EXPECT_NEAR(std::pow(after.cameras[0].sigmas[0] / before.cameras[0].sigmas[0], 2), of_lens, 1e-9);
  adjustment.halves[0].quantities[0].deviation = 100.0;
  EXPECT_EQ(Analyze(adjustment, c.dataset).covariance, before.covariance);
}

// The half in which it turns sides with its own larger piece.
TEST(CompareHalves, OfACameraThatComesLooseLateOrEarlyDiffer) {
  for (const double share : {0.25, 0.8}) {
    const std::vector<SensorHalves> halves = HalvesOfLoose(1.0, share);
    ASSERT_EQ(halves.size(), 1u);
    EXPECT_EQ(halves[0].parts, share < 0.5 ? DriveParts::kBeginning : DriveParts::kEnd) << share;
    EXPECT_GT(WorstOf(halves[0]), LargestByChance(halves)) << share;
  }
}

}  // namespace
}  // namespace mlic::split_halves_test
