// The own solver against Ceres on the same joint problem: same cost, same minimum, same covariance.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "ceres_reference/ceres_joint_problem.h"
#include "ceres_reference/comparison.h"
#include "mlic_core/association/plane_association.h"
#include "mlic_core/association/point_landmarks.h"
#include "mlic_core/problem/priors.h"
#include "support/simulated_input.h"
#include "support/synthetic_tracks.h"
#include "support/true_spline.h"

namespace mlic::ceres_reference_test {
namespace {

constexpr double kDegree = M_PI / 180.0;
constexpr double kImuRate = 200.0;                          // Hz
constexpr double kGyroscope = 2e-4, kAccelerometer = 2e-3;  // densities
constexpr double kPixel = 0.3;                              // px

struct Case {
  Dataset dataset;
  CalibrationState start;
  JointProblem problem;  // without its dataset, which may have moved
};

ImuSigma Sigma() {
  ImuSigma sigma;
  sigma.gyroscope.setConstant(kGyroscope * std::sqrt(kImuRate));
  sigma.accelerometer.setConstant(kAccelerometer * std::sqrt(kImuRate));
  return sigma;
}

void Disturb(Random* random, SensorCalibration* sensor) {
  const auto vector = [&] {
    const double x = random->Normal(), y = random->Normal();
    return Eigen::Vector3d(x, y, random->Normal());
  };
  sensor->T_imu_sensor.rotation = ExpQuaternion(2e-3 * vector()) * sensor->T_imu_sensor.rotation;
  sensor->T_imu_sensor.translation += 5e-3 * vector();
  sensor->time_offset += 3e-4 * random->Normal();
}

// What is compared: the data's and priors' cost at the start, where both end, and there the inverse of the
// normal matrix with the weights of the robust losses, priors included, control points and landmarks
// eliminated.
void ExpectSame(Case c) {
  c.problem.dataset = &c.dataset;
  const ceres_reference::OwnMinimum own = ceres_reference::FindOwnMinimum(c.problem, c.start);
  ASSERT_LT(own.last_change, 1e-4);
  ceres_reference::CeresJointProblem reference(c.problem, c.start);
  const ceres::Solver::Summary summary = reference.Solve({});
  ASSERT_TRUE(summary.IsSolutionUsable()) << summary.message;
  std::printf("  %s\n", summary.BriefReport().c_str());

  Eigen::MatrixXd prior;
  Eigen::VectorXd gradient;
  CalibrationPrior(c.problem, c.start, reference.layout(), &prior, &gradient);
  const double first_cost =
      own.first_cost + gradient.dot(prior.completeOrthogonalDecomposition().solve(gradient));
  EXPECT_NEAR(2.0 * summary.initial_cost, first_cost, 1e-9 * first_cost);

  const Eigen::VectorXd difference =
      ceres_reference::CalibrationDifference(reference.layout(), reference.State(), own.state);
  const double apart = ceres_reference::LargestInSigmas(difference, own.covariance);
  std::printf(
      "  minima %.1e sigma apart; %.0f sigma from the start\n", apart,
      ceres_reference::LargestInSigmas(
          ceres_reference::CalibrationDifference(reference.layout(), own.state, c.start), own.covariance));
  EXPECT_LT(apart, 1e-3);

  const Eigen::MatrixXd covariance = reference.Covariance(1);
  double largest = 0.0;
  for (int i = 0; i < covariance.rows(); ++i) {
    for (int k = 0; k < covariance.cols(); ++k) {
      const double scale = std::sqrt(own.covariance(i, i) * own.covariance(k, k));
      if (scale > 0.0) {
        largest = std::max(largest, std::abs(covariance(i, k) - own.covariance(i, k)) / scale);
      } else {
        EXPECT_EQ(covariance(i, k), 0.0);
      }
    }
  }
  std::printf("  covariances differ by %.1e of the variances\n", largest);
  EXPECT_LT(largest, 0.01);
}

TEST(CeresReference, FindsTheSameMinimumOfImuAndLidars) {
  constexpr double kDuration = 5.0;  // s
  const sim::SensorSet sensors = ConfiguredSensors("dual_rosette_imu_intrinsics.yaml");
  const sim::SimulationOptions options = DriveOptions(sim::Scenario::kHandheld, kDuration, 3);
  SimulatedInput input = SimulateInput(sensors, options, true);
  const auto trajectory =
      sim::MakeTrajectory(options.scenario, options.seed, kDuration, sensors.imu.T_body_imu);
  Case c;
  for (const auto& lidar : sensors.lidars) c.start.lidars.push_back(lidar.calibration);
  c.start.drives.emplace_back();
  c.start.drives[0].trajectory = TrueSpline(*trajectory, kDuration, 0.03);
  AssociationOptions association;
  association.points_per_scan = 300;
  DriveTerms& terms = c.problem.drives.emplace_back();
  terms.imu_sigma = {Sigma()};
  terms.planes = AssociatePlanes(input.dataset.drives[0], c.start, 0,
                                 std::vector<PlaneNoise>(sensors.lidars.size()), association);
  for (const LidarConfig& lidar : input.rig.lidars) c.problem.lidars.push_back({lidar.guess, false});
  c.problem.estimate_imu_matrices = true;
  c.problem.imu.alignment_sigma = ImuConfig().alignment_sigma;
  c.problem.imu.alignment_shown.setIdentity();
  Random random(7);
  for (SensorCalibration& lidar : c.start.lidars) Disturb(&random, &lidar);
  c.dataset = std::move(input.dataset);
  // A shock, so that the IMU's loss has its say.
  c.dataset.drives[0].imu[700].specific_force.x() += 3.0;
  ExpectSame(std::move(c));
}

// A rolling and a global shutter; a LiDAR that is known by single points of the map alone.
CalibrationState CamerasAndALidar() {
  CalibrationState state;
  CameraCalibration camera;
  camera.sensor = {{FromRollPitchYaw(kDegree * Eigen::Vector3d(-91.0, 1.0, -89.0)), {0.06, 0.11, -0.01}},
                   -0.02};
  camera.intrinsics = {
      CameraModel::kPlumbBob, 752, 480, {392.0, 391.0, 371.0, 244.0, -0.09, 0.018, 0.0004, -0.0006, -0.001}};
  state.cameras.push_back(camera);
  camera.sensor = {{FromRollPitchYaw(kDegree * Eigen::Vector3d(-89.0, 2.0, -71.0)), {0.05, -0.10, 0.02}},
                   0.013};
  camera.rolling_shutter = true;
  camera.readout = 0.02;
  camera.intrinsics = {
      CameraModel::kEquidistant, 640, 480, {305.0, 305.4, 318.0, 242.0, 0.01, -0.003, 0.0, 0.0}};
  state.cameras.push_back(camera);
  state.lidars.push_back(
      {{FromRollPitchYaw(kDegree * Eigen::Vector3d(3.0, -17.0, 128.0)), {0.08, -0.05, 0.12}}, 0.05});
  return state;
}

std::vector<ImuSample> NoisyImu(const SplitSpline& trajectory, double duration, Random* random) {
  const auto noise = [&](double density) {
    const double x = random->Normal(), y = random->Normal(), z = random->Normal();
    return Eigen::Vector3d(density * std::sqrt(kImuRate) * Eigen::Vector3d(x, y, z));
  };
  std::vector<ImuSample> imu;
  for (int i = 0; i <= static_cast<int>(duration * kImuRate); ++i) {
    const double t = i / kImuRate;
    const SplineBasis basis(trajectory.position.knots(), t);
    imu.push_back(
        {t, trajectory.rotation.AngularVelocity(t) + noise(kGyroscope),
         trajectory.rotation.Rotation(t).conjugate() * (trajectory.position.Acceleration(basis) - kGravity) +
             noise(kAccelerometer)});
  }
  return imu;
}

// What the LiDAR measured of every third point, up to half a second before or after a camera saw it.
void AddLidarPoints(const CalibrationState& truth, Random* random, LandmarkSet* set) {
  set->lidar_points.resize(set->points.size());
  const SplitSpline& trajectory = truth.drives[0].trajectory;
  for (std::size_t p = 0; p < set->points.size(); p += 3) {
    const double seen = set->observations[set->begin[p]].time + random->Uniform(-0.5, 0.5);
    LidarPointObservation& observation = set->lidar_points[p];
    observation.time = std::clamp(seen, trajectory.Start(), trajectory.End() - 0.1);
    observation.lidar = 0;
    const double t = observation.time + truth.lidars[0].time_offset;
    const double x = random->Normal(), y = random->Normal(), z = random->Normal();
    observation.position =
        (trajectory.Pose(t) * truth.lidars[0].T_imu_sensor).Inverse() * set->points[p].position +
        0.01 * Eigen::Vector3d(x, y, z);
    observation.sigma_along = 0.02f;
    observation.sigma_across = 0.01f;
  }
}

TEST(CeresReference, FindsTheSameMinimumOfImuAndCameras) {
  constexpr double kDuration = 12.0;  // s
  Case c;
  c.start = CamerasAndALidar();
  const auto trajectory = sim::MakeTrajectory(sim::Scenario::kHandheld, 3, kDuration, RigidTransform());
  c.start.drives.emplace_back();
  c.start.drives[0].trajectory = TrueSpline(*trajectory, kDuration, kSyntheticKnots);
  SyntheticTracksOptions options;
  options.duration = kDuration;
  options.points = 1500;
  options.noise = kPixel;
  options.outliers = 0.02;
  const TrackSet tracks = MakeTracks(c.start.drives[0].trajectory, c.start.cameras, options);
  LandmarkOptions landmarks;
  landmarks.largest_error = 8.0;  // some outliers stay for the loss
  DriveTerms& terms = c.problem.drives.emplace_back();
  terms.imu_sigma = {Sigma()};
  terms.landmarks = TriangulateLandmarks(tracks, c.start, 0, landmarks);
  Random random(11);
  AddLidarPoints(c.start, &random, &terms.landmarks);
  c.dataset.drives.emplace_back();
  c.dataset.drives[0].imu = NoisyImu(c.start.drives[0].trajectory, kDuration, &random);
  c.problem.lidars.resize(1);
  c.problem.cameras.resize(2);
  c.problem.imu.alignment_sigma = ImuConfig().alignment_sigma;
  c.problem.imu.alignment_shown.setIdentity();
  c.problem.imu.gravity_sigma = 0.03;
  c.problem.imu.lag_sigma = 0.01;
  c.problem.cameras[0].fixed.square_pixels = true;
  c.problem.cameras[1].fixed.intrinsics = {false, false, false, false, false, false, true, true};
  Disturb(&random, &c.start.lidars[0]);
  for (CameraCalibration& camera : c.start.cameras) {
    Disturb(&random, &camera.sensor);
    camera.intrinsics.parameters[0] += 2.0;
  }
  ExpectSame(std::move(c));
}

}  // namespace
}  // namespace mlic::ceres_reference_test
