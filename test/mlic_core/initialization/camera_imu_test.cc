#include "mlic_core/initialization/camera_imu/camera_imu.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "mlic_core/initialization/knot_spacing.h"
#include "mlic_core/uncertainty/observability.h"
#include "support/synthetic_tracks.h"
#include "support/true_spline.h"

namespace mlic::camera_imu_test {
namespace {

constexpr double kDegree = M_PI / 180.0;
constexpr double kImuRate = 200.0;

CameraCalibration Camera(const Eigen::Vector3d& rpy_deg, const Eigen::Vector3d& translation,
                         double time_offset) {
  CameraCalibration camera;
  camera.sensor.T_imu_sensor = {FromRollPitchYaw(rpy_deg * kDegree), translation};
  camera.sensor.time_offset = time_offset;
  camera.intrinsics = {CameraModel::kPlumbBob,
                       752,
                       480,
                       {392.8, 392.1, 371.4, 243.9, -0.0914, 0.0183, 0.0004, -0.0006, -0.0011}};
  return camera;
}

std::vector<CameraCalibration> Stereo() {
  return {Camera({-91.3, 1.1, -88.9}, {0.061, 0.108, -0.013}, -0.0085),
          Camera({-89.2, -0.8, -92.1}, {0.058, -0.101, -0.009}, 0.0113)};
}

struct ImuErrors {
  double gyroscope = 0.0, accelerometer = 0.0;  // densities of white noise
  Eigen::Vector3d gyroscope_bias{-0.0042, 0.0031, 0.0017};
  Eigen::Vector3d accelerometer_bias{0.043, 0.052, -0.061};
};

ImuSample SampleAt(const SplitSpline& trajectory, double t, const ImuErrors& errors) {
  const SplineBasis basis(trajectory.position.knots(), t);
  const Eigen::Quaterniond R = trajectory.rotation.Rotation(t);
  return {t, trajectory.rotation.AngularVelocity(t) + errors.gyroscope_bias,
          R.conjugate() * (trajectory.position.Acceleration(basis) - kGravity) + errors.accelerometer_bias};
}

std::vector<ImuSample> MakeImu(const SplitSpline& trajectory, double duration, const ImuErrors& errors,
                               std::uint64_t seed) {
  std::vector<ImuSample> samples;
  Random random(seed);
  const double root_rate = std::sqrt(kImuRate);
  const auto noise = [&](double density) {
    const double x = random.Normal(), y = random.Normal(), z = random.Normal();
    return Eigen::Vector3d(density * root_rate * Eigen::Vector3d(x, y, z));
  };
  for (int i = 0; i <= static_cast<int>(duration * kImuRate); ++i) {
    samples.push_back(SampleAt(trajectory, i / kImuRate, errors));
    samples.back().angular_velocity += noise(errors.gyroscope);
    samples.back().specific_force += noise(errors.accelerometer);
  }
  return samples;
}

struct Case {
  std::vector<CameraCalibration> truth;
  SplitSpline trajectory;
  ImuErrors imu;
  Rig rig;
  Dataset dataset;
  std::vector<CameraStart> start;
  std::vector<TrackSet> tracks;

  Initialization Run(CameraInitialization* cameras = nullptr) const {
    CameraInitialization unused;
    return InitializeFromCameras(rig, dataset, start, tracks, CancellationToken(),
                                 cameras != nullptr ? cameras : &unused);
  }
};

Case MakeCase(const std::vector<CameraCalibration>& truth, const SyntheticTracksOptions& options,
              const ImuErrors& imu, sim::Scenario scenario = sim::Scenario::kHandheld,
              std::uint64_t seed = 7) {
  Case c;
  c.truth = truth;
  c.imu = imu;
  c.trajectory = TrueSpline(*sim::MakeTrajectory(scenario, seed, options.duration, RigidTransform()),
                            options.duration, kSyntheticKnots);
  c.dataset.drives.emplace_back();
  c.dataset.drives[0].imu = MakeImu(c.trajectory, options.duration, imu, seed + 100);
  c.tracks.push_back(MakeTracks(c.trajectory, truth, options));
  c.rig = RigOf(truth);
  c.start = StartsOf(truth);
  return c;
}

void StartFromFieldOfView(Case* c, double fov_deg) {
  for (std::size_t i = 0; i < c->truth.size(); ++i) {
    const CameraIntrinsics& t = c->truth[i].intrinsics;
    c->start[i] = {IntrinsicsFromFieldOfView(t.model, t.width, t.height, fov_deg), true};
  }
}

struct Errors {
  double degrees = 0.0, metres = 0.0, milliseconds = 0.0, pixels = 0.0;
  double path_share = 0.0;  // of the path's length, the scale's error
};

double PathLength(const SplitSpline& trajectory, double start, double end) {
  double length = 0.0;
  for (double t = start; t + 0.05 <= end; t += 0.05) {
    length += (trajectory.Pose(t + 0.05).translation - trajectory.Pose(t).translation).norm();
  }
  return length;
}

void Print(const Initialization& result) {
  for (const std::string& line : result.notes) std::printf("  %s\n", line.c_str());
  for (const std::string& line : result.problems) std::printf("  problem: %s\n", line.c_str());
}

Errors Worst(const Case& c, const Initialization& result) {
  Errors worst;
  Print(result);
  if (result.state.drives.size() != 1 || result.state.cameras.size() != c.truth.size()) {
    ADD_FAILURE() << "no state";
    return {1e3, 1e3, 1e3, 1e3, 1e3};
  }
  for (std::size_t i = 0; i < c.truth.size(); ++i) {
    const SensorCalibration &truth = c.truth[i].sensor, &found = result.state.cameras[i].sensor;
    const double degrees = AngleBetween(truth.T_imu_sensor.rotation, found.T_imu_sensor.rotation) / kDegree;
    const double metres = (truth.T_imu_sensor.translation - found.T_imu_sensor.translation).norm();
    const double milliseconds = 1e3 * std::abs(truth.time_offset - found.time_offset);
    const double pixels = MeanDisplacement(c.truth[i].intrinsics, result.state.cameras[i].intrinsics);
    std::printf("  camera %zu: %.6f deg %.4f mm %.6f ms intrinsics %.5f px\n", i, degrees, 1e3 * metres,
                milliseconds, pixels);
    worst.degrees = std::max(worst.degrees, degrees);
    worst.metres = std::max(worst.metres, metres);
    worst.milliseconds = std::max(worst.milliseconds, milliseconds);
    worst.pixels = std::max(worst.pixels, pixels);
  }
  const SplitSpline& trajectory = result.state.drives[0].trajectory;
  const double start = std::max(0.5, trajectory.Start()), end = trajectory.End() - 0.5;
  const double truth = PathLength(c.trajectory, start, end);
  worst.path_share = std::abs(PathLength(trajectory, start, end) / truth - 1.0);
  std::printf("  path of %.1f m wrong by %.4f %%\n", truth, 100.0 * worst.path_share);
  return worst;
}

TEST(VisualInitialization, NoiseFreeTracksGiveTheTruth) {
  SyntheticTracksOptions options;
  options.duration = 20.0;
  options.points = 4000;
  Case c = MakeCase(Stereo(), options, ImuErrors());
  c.rig.imu.gravity = kGravity.norm();
  c.rig.imu.alignment_sigma = 0.0;
  const Errors worst = Worst(c, c.Run());
  // To what splines with knots 62.5 ms apart, as they are chosen here, leave of a trajectory with 50 ms. The
  // accelerometer's lag, which cannot be given, takes some of it for its own.
  EXPECT_LT(worst.degrees, 5e-3);
  EXPECT_LT(worst.metres, 3e-4);
  EXPECT_LT(worst.milliseconds, 1e-2);
  EXPECT_LT(worst.pixels, 0.06);
  EXPECT_LT(worst.path_share, 2e-4);
}

ImuErrors RealImu() {
  ImuErrors imu;
  imu.gyroscope = 2e-4;
  imu.accelerometer = 2e-3;
  return imu;
}

TEST(VisualInitialization, FindsEverythingFromTheFieldOfView) {
  SyntheticTracksOptions options;
  options.noise = 0.5;
  Case c = MakeCase(Stereo(), options, RealImu());
  StartFromFieldOfView(&c, 90.0);
  const Errors worst = Worst(c, c.Run());
  EXPECT_LT(worst.degrees, 0.05);
  EXPECT_LT(worst.metres, 4e-3);
  EXPECT_LT(worst.milliseconds, 0.1);
  EXPECT_LT(worst.pixels, 0.5);
  EXPECT_LT(worst.path_share, 0.002);
}

// A last sample just after a knot touches the last control point by next to nothing.
TEST(VisualInitialization, SamplesMayEndJustAfterAKnot) {
  SyntheticTracksOptions options;
  options.noise = 0.5;
  options.duration = 14.0;
  options.points = 3000;
  Case c = MakeCase(Stereo(), options, RealImu());
  std::vector<ImuSample>& imu = c.dataset.drives[0].imu;
  const auto cut = [&](double end) {
    while (imu.back().time >= end) imu.pop_back();
  };
  cut(13.55);
  const double spacing = ChooseKnotSpacing(imu).position;
  const double end = imu.front().time + std::floor(13.5 / spacing) * spacing + 1e-6;
  cut(end);
  imu.push_back(SampleAt(c.trajectory, end, c.imu));
  ASSERT_EQ(ChooseKnotSpacing(imu).position, spacing);
  const Errors worst = Worst(c, c.Run());
  EXPECT_LT(worst.degrees, 0.08);
  EXPECT_LT(worst.metres, 6e-3);
}

// Squared errors of all cameras' poses and offsets by their covariance; in the mean one.
double NormalizedSquare(const Case& c, const Initialization& result, const CameraInitialization& cameras) {
  JointProblem problem;
  for (const FixedCameraParameters& held : cameras.held) problem.cameras.emplace_back().fixed = held;
  const ObservabilityAnalysis analysis = AnalyzeCalibration(problem, result.state, cameras.information);
  const int size = 7 * static_cast<int>(c.truth.size());
  Eigen::VectorXd error(size);
  for (std::size_t i = 0; i < c.truth.size(); ++i) {
    const SensorCalibration &truth = c.truth[i].sensor, &found = result.state.cameras[i].sensor;
    error.segment<7>(7 * i) << Log(found.T_imu_sensor.rotation * truth.T_imu_sensor.rotation.conjugate()),
        found.T_imu_sensor.translation - truth.T_imu_sensor.translation,
        found.time_offset - truth.time_offset;
  }
  std::printf("  normalized:");
  for (int k = 0; k < size; ++k) std::printf(" %.1f", error[k] / std::sqrt(analysis.covariance(k, k)));
  const double square = error.dot(analysis.covariance.ldlt().solve(error)) / size;
  std::printf("  square %.2f\n", square);
  return square;
}

TEST(VisualInitialization, ErrorsAreAsLargeAsTheirSigmas) {
  SyntheticTracksOptions options;
  options.noise = 0.5;
  options.duration = 20.0;
  options.points = 4000;
  double sum = 0.0;
  constexpr int kSeeds = 6;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    options.seed = seed;
    const Case c =
        MakeCase(Stereo(), options, RealImu(), sim::Scenario::kHandheld, static_cast<std::uint64_t>(seed));
    CameraInitialization cameras;
    const Initialization result = c.Run(&cameras);
    ASSERT_EQ(result.state.drives.size(), 1u);
    sum += NormalizedSquare(c, result, cameras) / kSeeds;
  }
  EXPECT_GT(sum, 0.5);
  EXPECT_LT(sum, 1.6);
}

TEST(VisualInitialization, OneCameraIsEnoughAndEveryTenthObservationMayBeWrong) {
  SyntheticTracksOptions options;
  options.noise = 0.5;
  options.outliers = 0.1;
  Case c = MakeCase({Stereo()[1]}, options, RealImu());
  StartFromFieldOfView(&c, 85.0);
  const Errors worst = Worst(c, c.Run());
  EXPECT_LT(worst.degrees, 0.08);
  EXPECT_LT(worst.metres, 6e-3);
  EXPECT_LT(worst.milliseconds, 0.2);
  EXPECT_LT(worst.pixels, 0.7);
  EXPECT_LT(worst.path_share, 0.003);
}

// What an IMU is built like, and where it is, is no reason to reject a camera that agrees with it otherwise.
TEST(VisualInitialization, AxesGravityAndLagOfTheAccelerometerCostNoCamera) {
  SyntheticTracksOptions options;
  options.noise = 0.3;
  options.duration = 20.0;
  options.points = 4000;
  Case c = MakeCase(Stereo(), options, RealImu());
  constexpr double kLag = 0.006, kLessGravity = 0.02;  // s, m/s^2
  const Eigen::Quaterniond turned = FromRollPitchYaw(Eigen::Vector3d(1.7, -1.1, 0.9) * kDegree);
  for (ImuSample& sample : c.dataset.drives[0].imu) {
    const double t = std::max(0.0, sample.time - kLag);
    const SplineBasis basis(c.trajectory.position.knots(), t);
    const Eigen::Vector3d force = c.trajectory.position.Acceleration(basis) - kGravity;
    const SplineBasis now(c.trajectory.position.knots(), sample.time);
    const Eigen::Vector3d noise =
        sample.specific_force - c.trajectory.rotation.Rotation(sample.time).conjugate() *
                                    (c.trajectory.position.Acceleration(now) - kGravity);
    sample.specific_force = turned * (c.trajectory.rotation.Rotation(t).conjugate() *
                                      (force - Eigen::Vector3d(0.0, 0.0, kLessGravity))) +
                            noise;
  }
  CameraInitialization cameras;
  const Initialization result = c.Run(&cameras);
  const Errors worst = Worst(c, result);
  for (std::size_t i = 0; i < c.truth.size(); ++i) {
    EXPECT_TRUE(cameras.found[i]);
    EXPECT_LT(cameras.noise[i].spread, 1.2) << i;
  }
  EXPECT_EQ(result.state.accelerometer_lag, 0.0);  // what is still wrong of a start looks like one
  EXPECT_LT(worst.metres, 0.02);
  EXPECT_LT(worst.pixels, 1.0);
}

// Rotors shake the accelerometer by more than the rig is moved by, far above the band of its positions.
TEST(VisualInitialization, VibrationDoesNotHideTheScale) {
  SyntheticTracksOptions options;
  options.noise = 0.5;
  options.duration = 20.0;
  options.points = 4000;
  Case c = MakeCase(Stereo(), options, RealImu());
  constexpr double kFrequency = 73.0, kAmplitude = 3.0;  // Hz, m/s^2
  for (ImuSample& sample : c.dataset.drives[0].imu) {
    sample.specific_force +=
        kAmplitude * std::sin(2.0 * M_PI * kFrequency * sample.time) * Eigen::Vector3d(0.5, 0.4, 0.77);
  }
  const Errors worst = Worst(c, c.Run());
  EXPECT_LT(worst.degrees, 0.1);
  EXPECT_LT(worst.metres, 0.02);
  EXPECT_LT(worst.path_share, 0.01);
}

// A rig that is set down, or bumps into something, is shaken for a second in all frequencies.
TEST(VisualInitialization, KnocksDoNotHideTheScale) {
  SyntheticTracksOptions options;
  options.noise = 0.5;
  options.duration = 30.0;
  options.points = 4000;
  Case c = MakeCase(Stereo(), options, RealImu());
  Random random(11);
  for (ImuSample& sample : c.dataset.drives[0].imu) {
    const bool knock = std::abs(sample.time - 14.0) < 0.5 || std::abs(sample.time - 22.0) < 0.5;
    const Eigen::Vector3d shaken(random.Normal(), random.Normal(), random.Normal());
    if (knock) sample.specific_force += 8.0 * shaken;
  }
  const Errors worst = Worst(c, c.Run());
  EXPECT_LT(worst.degrees, 0.1);
  EXPECT_LT(worst.metres, 0.02);
  EXPECT_LT(worst.path_share, 0.01);
}

// Noise across the measured directions would be less in a smaller world: a short drive, whose forces weigh
// less than its many observations, would shrink until none of its forces are explained.
TEST(VisualInitialization, NoiseDoesNotShrinkAShortDrive) {
  SyntheticTracksOptions options;
  options.noise = 2.0;
  options.duration = 8.0;
  options.points = 8000;
  ImuErrors imu = RealImu();
  imu.accelerometer = 2e-2;
  const Case c = MakeCase(Stereo(), options, imu);
  const Errors worst = Worst(c, c.Run());
  EXPECT_LT(worst.degrees, 0.5);
  EXPECT_LT(worst.path_share, 0.02);
}

SyntheticTracksOptions SeenFromACar() {
  SyntheticTracksOptions options;
  options.noise = 0.5;
  options.nearest = 4.0;
  options.farthest = 20.0;
  return options;
}

// Of each camera's pose, off by 4.81 deg and 0.1 m.
void GuessRoughly(std::uint64_t seed, Case* c) {
  Random random(seed);
  const auto direction = [&] {
    return Eigen::Vector3d(random.Normal(), random.Normal(), random.Normal()).normalized();
  };
  for (std::size_t i = 0; i < c->truth.size(); ++i) {
    ExtrinsicGuess guess;
    guess.T_imu_sensor = c->truth[i].sensor.T_imu_sensor;
    guess.T_imu_sensor.rotation = ExpQuaternion(4.81 * kDegree * direction()) * guess.T_imu_sensor.rotation;
    guess.T_imu_sensor.translation += 0.1 * direction();
    c->rig.cameras[i].guess = guess;
  }
}

// A car turns about one axis: what that leaves open comes from the guess; the scale is there, as it speeds up
// sideways to either side.
void ExpectTheGuessIsEnough(const std::vector<CameraCalibration>& cameras) {
  SyntheticTracksOptions options = SeenFromACar();
  options.duration = 40.0;
  Case c = MakeCase(cameras, options, RealImu(), sim::Scenario::kFigureEight);
  StartFromFieldOfView(&c, 90.0);
  GuessRoughly(3, &c);
  const Errors worst = Worst(c, c.Run());
  EXPECT_LT(worst.degrees, 0.5);
  EXPECT_LT(worst.metres, 0.25);       // z stays at the guess
  EXPECT_LT(worst.milliseconds, 2.0);  // gentle turns hardly tell it: 0.1 to 6 ms as the noise is drawn
  EXPECT_LT(worst.pixels, 5.0);        // the centre trades with the rotation
  EXPECT_LT(worst.path_share, 0.01);
}

TEST(VisualInitialization, ACarNeedsAGuessOnly) { ExpectTheGuessIsEnough(Stereo()); }

// Before the path is known, the only way that a camera is known to go is that about the IMU as it turns, and
// where the lever arm is long that looked like the way of the car: the start was turned by 30 deg.
TEST(VisualInitialization, ACarNeedsAGuessOnlyWhereLeverArmsAreLong) {
  std::vector<CameraCalibration> cameras = Stereo();
  for (CameraCalibration& camera : cameras) {
    camera.sensor.T_imu_sensor.translation += Eigen::Vector3d(-1.2, -0.9, 0.2);
  }
  ExpectTheGuessIsEnough(cameras);
}

// On flat ground gravity is told from a bias by its length, upwards as well as downwards, and until positions
// are known wrong observations decide.
TEST(VisualInitialization, WrongObservationsTurnNothingOver) {
  SyntheticTracksOptions options = SeenFromACar();
  options.duration = 24.0;
  options.outliers = 0.3;
  for (const std::uint64_t seed : {1, 2}) {
    Case c = MakeCase({Stereo()[0]}, options, RealImu(), sim::Scenario::kPlanar, seed);
    ExtrinsicGuess guess;
    guess.T_imu_sensor = c.truth[0].sensor.T_imu_sensor;
    c.rig.cameras[0].guess = guess;
    const Initialization result = c.Run();
    ASSERT_EQ(result.state.drives.size(), 1u) << seed;
    const So3Spline& rotation = result.state.drives[0].trajectory.rotation;
    EXPECT_GT((rotation.Rotation(0.5 * options.duration) * Eigen::Vector3d::UnitZ()).z(), 0.99) << seed;
    EXPECT_LT(std::abs(result.state.drives[0].bias.Mean()[5]), 0.5) << seed;
  }
}

// A focal length that was held where few observations determine it came out at 943 px, and the lever arm,
// which forces moved by a metre, at 1.3 m.
TEST(VisualInitialization, ACarOnFlatGroundNeedsNoBetterGuessOfItsLens) {
  SyntheticTracksOptions options = SeenFromACar();
  options.duration = 23.0;
  options.outliers = 0.2;
  CameraCalibration camera = Camera({-95.5, -9.4, 165.2}, {0.24, 0.49, -0.55}, -0.036);
  camera.intrinsics.parameters = {692.5, 692.2, 374.5, 238.7, -0.127, 0.017, 0.0001, -0.0005, -0.0006};
  Case c = MakeCase({camera}, options, RealImu(), sim::Scenario::kPlanar, 4);
  for (ImuSample& sample : c.dataset.drives[0].imu) {  // warms up
    sample.angular_velocity += std::exp(-sample.time / 50.0) * Eigen::Vector3d(-0.0012, -0.0011, -0.0002);
  }
  StartFromFieldOfView(&c, 59.0);
  GuessRoughly(4, &c);
  const Errors worst = Worst(c, c.Run());
  EXPECT_LT(worst.degrees, 0.6);
  EXPECT_LT(worst.metres, 0.15);
  EXPECT_LT(worst.milliseconds, 5.0);
  EXPECT_LT(worst.pixels, 6.0);
}

// Steady turning on a plane: what the accelerometer reads is as well a bias.
TEST(VisualInitialization, RefusesAScaleThatTheMotionDoesNotShow) {
  const SyntheticTracksOptions options = SeenFromACar();
  for (const sim::Scenario scenario :
       {sim::Scenario::kCircle, sim::Scenario::kStraight, sim::Scenario::kStatic}) {
    Case c = MakeCase(Stereo(), options, RealImu(), scenario);
    for (std::size_t i = 0; i < c.truth.size(); ++i) {
      // With the camera's pose as a guess: nothing but the scale is in question.
      ExtrinsicGuess guess;
      guess.T_imu_sensor = c.truth[i].sensor.T_imu_sensor;
      c.rig.cameras[i].guess = guess;
    }
    const Initialization result = c.Run();
    Print(result);
    EXPECT_TRUE(result.state.drives.empty());
    ASSERT_FALSE(result.problems.empty());
    const bool still =
        result.problems.back().find("stands still or moves evenly for 100 %") != std::string::npos;
    if (scenario == sim::Scenario::kStatic) {
      EXPECT_TRUE(still);
    } else if (scenario == sim::Scenario::kCircle) {
      EXPECT_FALSE(still);
      for (CameraConfig& camera : c.rig.cameras) camera.guess.reset();
      EXPECT_NE(c.Run().problems.back().find("about one axis only"), std::string::npos);
    }
  }
}

}  // namespace
}  // namespace mlic::camera_imu_test
