#include "joint_solver_case.h"

#include "mlic_core/association/plane_association.h"
#include "mlic_core/common/random.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/initialization/knot_spacing.h"
#include "mlic_core/lidar/scan_filter.h"
#include "mlic_sim/simulation.h"

namespace mlic {
namespace {

constexpr std::uint64_t kSeed = 1;
constexpr std::size_t kPointsPerScan = 2000;  // as in the last rounds of a calibration

// The trajectory with the knots that a calibration of this drive would take.
SplitSpline SplineOf(const sim::Trajectory& trajectory, const std::vector<ImuSample>& imu, double duration) {
  const KnotSpacing spacing = ChooseKnotSpacing(imu);
  const UniformKnots rotation = UniformKnots::Covering(0.0, duration, spacing.rotation);
  const UniformKnots position = UniformKnots::Covering(0.0, duration, spacing.position);
  std::vector<Eigen::Quaterniond> rotations;
  std::vector<Eigen::Vector3d> positions;
  for (int j = 0; j < rotation.count; ++j) {
    rotations.push_back(trajectory.PoseAt(rotation.ControlPointTime(j)).rotation);
  }
  for (int j = 0; j < position.count; ++j) {
    positions.push_back(trajectory.PoseAt(position.ControlPointTime(j)).translation);
  }
  return {So3Spline(rotation, std::move(rotations)), PositionSpline(position, std::move(positions))};
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

}  // namespace

JointSolverCase MakeJointSolverCase(const std::string& file, bool car, double duration) {
  const sim::SensorSet sensors = sim::LoadSensorSet("config/simulation/" + file);
  sim::SimulationOptions options;
  options.scenario = car ? sim::Scenario::kFigureEight : sim::Scenario::kHandheld;
  options.duration = duration;
  options.seed = kSeed;
  sim::GuessOptions guess;
  guess.with_guess = car;
  const Rig rig = sim::RigFromSensorSet(sensors, guess);
  Drive drive = sim::SimulateDrive(sensors, options, [](LidarScan& scan) { FilterScan(scan); });
  const auto trajectory =
      sim::MakeTrajectory(options.scenario, options.seed, duration, sensors.imu.T_body_imu);

  JointSolverCase made;
  made.start.lidars = sim::TrueCalibrations(sensors);
  made.start.drives.emplace_back();
  made.start.drives[0].trajectory = SplineOf(*trajectory, drive.imu, duration);
  AssociationOptions association;
  association.root_voxel = RootVoxelSize(drive);
  association.points_per_scan = kPointsPerScan;
  std::vector<PlaneNoise> noise(rig.lidars.size());
  DriveTerms& terms = made.problem.drives.emplace_back();
  for (int round = 0; round < 2; ++round) {  // with the noise that the first shows
    terms.planes = AssociatePlanes(drive, made.start, 0, noise, association);
    noise = MeasurePlaneNoise(made.problem.drives, made.start, noise);
  }
  terms.imu_sigma = {SampleSigma(drive.imu, std::nullopt)};
  for (const LidarConfig& lidar : rig.lidars) made.problem.lidars.push_back({lidar.guess, false});
  Random random(kSeed);
  for (SensorCalibration& lidar : made.start.lidars) Disturb(&random, &lidar);
  made.dataset.drives.emplace_back();
  made.dataset.drives[0].imu = std::move(drive.imu);
  return made;
}

}  // namespace mlic
