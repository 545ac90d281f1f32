#include "mlic_core/initialization/lidar_imu.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "mlic_core/common/order_statistics.h"
#include "mlic_core/imu/excitation.h"
#include "mlic_core/imu/gravity_lever_arm.h"
#include "mlic_core/imu/hand_eye.h"
#include "mlic_core/imu/relative_motion.h"
#include "mlic_core/initialization/knot_spacing.h"
#include "mlic_core/initialization/loose_lidars.h"
#include "mlic_core/initialization/pose_fit.h"

namespace mlic {
namespace {

// Whether it is the motion or the LiDARs, the gyroscope tells.
std::string WhyNoneAgrees(const Dataset& dataset) {
  constexpr double kShort = 5.0;  // s; from: structural, chooses the words of a message
  double longest = 0.0;
  for (const Drive& drive : dataset.drives) {
    longest = std::max(longest, drive.imu.back().time - drive.imu.front().time);
  }
  const std::string what = "no LiDAR's rotation agrees with the gyroscope's: ";
  if (longest < kShort) return what + "the drive lasts less than 5 s; record 30 s or more";
  if (!TurnsEnough(dataset)) {
    return what +
           "the drive turns too little, or too evenly, to show time offset and rotation; record a drive with "
           "turns "
           "(figure-eights; by hand: about all axes)";
  }
  return what +
         "it turns enough, but the LiDARs' scans cannot be followed (they see too little structure, such as "
         "a floor alone, or come from another drive) or lie more than 1 s off; record among walls and "
         "objects";
}

// Starts the drive's trajectory from the base LiDAR's odometry: gravity-aligned, position and yaw of the
// first pose zero; then the spline is fitted to poses and IMU together.
bool InitializeDrive(const Dataset& dataset, std::size_t d, const std::vector<TimedPose>& odometry,
                     const AngularRateAlignment& alignment, const GravityLeverArm& arm,
                     Initialization* result, RigidTransform* T_imu_base) {
  const Drive& drive = dataset.drives[d];
  if (!arm.valid) {
    result->problems.push_back("gravity and lever arm were not found: " + arm.failure);
    return false;
  }
  // Accelerations show what of the rotation turning about one axis leaves open.
  if (d == 0) *T_imu_base = {arm.R_imu_lidar, arm.p_imu_lidar};
  // Turns the odometry's gravity down, then the first pose's yaw to zero.
  const Eigen::Quaterniond upright = Eigen::Quaterniond::FromTwoVectors(arm.gravity, kGravity);
  const RigidTransform T_base_imu = T_imu_base->Inverse();
  std::vector<TimedPose> imu_poses;
  for (const TimedPose& pose : odometry) {
    const RigidTransform T = RigidTransform{upright, Eigen::Vector3d::Zero()} * pose.pose * T_base_imu;
    imu_poses.push_back({pose.time + alignment.time_offset, T});
  }
  const Eigen::Vector3d x_axis = imu_poses.front().pose.rotation * Eigen::Vector3d::UnitX();
  const double yaw = std::atan2(x_axis.y(), x_axis.x());
  const RigidTransform level{Eigen::Quaterniond(Eigen::AngleAxisd(-yaw, Eigen::Vector3d::UnitZ())),
                             Eigen::Vector3d::Zero()};
  const Eigen::Vector3d origin = level * imu_poses.front().pose.translation;
  for (TimedPose& pose : imu_poses) {
    pose.pose = level * pose.pose;
    pose.pose.translation -= origin;
  }
  const double start = std::max(drive.imu.front().time, imu_poses.front().time - 0.05);
  const double end = std::min(drive.imu.back().time, imu_poses.back().time + 0.05);
  const KnotSpacing spacing = ChooseKnotSpacing(drive.imu, MedianPeriod(odometry));
  char line[160];
  std::snprintf(line, sizeof(line), "knots every %.0f ms (rotation) and %.0f ms (position)",
                1e3 * spacing.rotation, 1e3 * spacing.position);
  result->notes.push_back(line);
  DriveState state;
  state.trajectory = SplineThrough(imu_poses, UniformKnots::Covering(start, end, spacing.rotation),
                                   UniformKnots::Covering(start, end, spacing.position));
  state.bias = {alignment.gyroscope_bias, arm.accelerometer_bias};
  result->state.drives.push_back(FitToPoses(drive, result->imu_sigma[d], imu_poses,
                                            std::max(1e-3, alignment.residual_rms),
                                            std::max(5e-3, arm.residual_rms), std::move(state)));
  return true;
}

// From about the middle of the poses, where the alignment has the offset, to about that of the trajectory.
void SetClock(const AngularRateAlignment& alignment, const ClockDrift& clock, const SplitSpline& trajectory,
              SensorCalibration* calibration) {
  calibration->time_offset = alignment.time_offset;
  if (clock.drift == 0.0) return;
  calibration->time_offset += clock.drift * (trajectory.Middle() - clock.middle);
  calibration->clock_drift = clock.drift;
}

// Of each LiDAR, by any drive; says by how much they turned.
std::vector<bool> LooseLidars(const Rig& rig, const Dataset& dataset,
                              const std::vector<DriveOdometry>& odometry, std::vector<std::string>* notes) {
  std::vector<bool> loose(rig.lidars.size(), false);
  for (std::size_t d = 0; d < odometry.size(); ++d) {
    std::vector<std::optional<MountTurn>> turns;
    for (std::size_t l = 0; l < loose.size(); ++l) {
      turns.push_back(
          MeasureMountTurn(dataset.drives[d].imu, odometry[d].lidars[l], odometry[d].alignments[l]));
    }
    const std::vector<bool> found = FindLoose(turns);
    for (std::size_t l = 0; l < loose.size(); ++l) {
      if (!found[l]) continue;
      loose[l] = true;
      char line[160];
      std::snprintf(line, sizeof(line),
                    ": rejected, it turned by %.2f deg (%.0f sigmas) against the IMU within the drive",
                    turns[l]->angle * 180.0 / M_PI, turns[l]->sigmas);
      notes->push_back(rig.lidars[l].name + line);
    }
  }
  return loose;
}

// The base is the LiDAR that agrees best with gyroscope and accelerometer over all drives; none: no LiDAR
// does.
struct BaseLidar {
  std::optional<std::size_t> lidar;
  std::vector<GravityLeverArm> arms;  // for each drive
};

BaseLidar ChooseBase(const Rig& rig, const Dataset& dataset, const std::vector<DriveOdometry>& odometry,
                     const std::vector<bool>& loose) {
  BaseLidar base;
  double best = std::numeric_limits<double>::infinity();
  for (std::size_t l = 0; l < rig.lidars.size(); ++l) {
    const bool usable = std::all_of(odometry.begin(), odometry.end(), [&](const DriveOdometry& of_drive) {
      return IsUsable(of_drive.alignments[l]);
    });
    if (loose[l] || !usable) continue;
    double disagreement = 0.0;
    std::vector<GravityLeverArm> arms;
    for (std::size_t d = 0; d < odometry.size(); ++d) {
      const AngularRateAlignment& a = odometry[d].alignments[l];
      arms.push_back(SolveGravityLeverArm(dataset.drives[d].imu, odometry[d].lidars[l], a.R_imu_lidar,
                                          a.time_offset, a.gyroscope_bias, LeverArmGuessOf(rig.lidars[l]),
                                          a.rotation_covariance));
      disagreement += Disagreement(a, arms.back());
    }
    if (disagreement >= best) continue;
    best = disagreement;
    base = {l, std::move(arms)};
  }
  return base;
}

}  // namespace

bool TurnsEnough(const Dataset& dataset) {
  constexpr double kTurning = 0.1;  // rad/s, root mean square; from: guard, far above an odometry's errors
  return std::any_of(dataset.drives.begin(), dataset.drives.end(), [](const Drive& drive) {
    return MeasureExcitation(drive.imu).principal_rms[2] >= kTurning;
  });
}

Initialization Initialize(const Rig& rig, const Dataset& dataset, const std::vector<DriveOdometry>& odometry,
                          const CancellationToken& cancellation) {
  Initialization result;
  const std::size_t lidars = rig.lidars.size();
  for (const Drive& drive : dataset.drives) {
    result.imu_sigma.push_back(SampleSigma(drive.imu, rig.imu.noise));
  }
  result.loose = LooseLidars(rig, dataset, odometry, &result.notes);
  const auto [chosen, arms] = ChooseBase(rig, dataset, odometry, result.loose);
  if (!chosen) {
    result.problems.push_back(WhyNoneAgrees(dataset));
    return result;
  }
  const std::size_t base = result.base_lidar = *chosen;
  result.notes.push_back("base LiDAR: " + rig.lidars[base].name);
  result.state.lidars.resize(lidars);
  result.unaligned.assign(lidars, false);
  RigidTransform T_imu_base;
  for (std::size_t d = 0; d < dataset.drives.size(); ++d) {
    cancellation.ThrowIfCancelled();
    if (!InitializeDrive(dataset, d, odometry[d].lidars[base], odometry[d].alignments[base], arms[d], &result,
                         &T_imu_base)) {
      return result;
    }
  }
  for (std::size_t l = 0; l < lidars; ++l) {
    SensorCalibration& calibration = result.state.lidars[l];
    const AngularRateAlignment& alignment = odometry[0].alignments[l];
    if (l == base) {
      calibration.T_imu_sensor = T_imu_base;
      SetClock(alignment, odometry[0].clocks[l], result.state.drives[0].trajectory, &calibration);
      continue;
    }
    if (!IsUsable(alignment)) {
      result.problems.push_back(
          rig.lidars[l].name +
          ": its odometry does not agree with the gyroscope's rotation (field of view blocked, "
          "too little structure, or another vehicle's topic)");
      if (rig.lidars[l].guess) calibration.T_imu_sensor = rig.lidars[l].guess->T_imu_sensor;
      result.unaligned[l] = true;
      continue;
    }
    SetClock(alignment, odometry[0].clocks[l], result.state.drives[0].trajectory, &calibration);
    constexpr double kInterval = 1.0;
    const auto motions = RelativeMotions(result.state.drives[0].trajectory, odometry[0].lidars[l],
                                         alignment.time_offset, kInterval);
    const HandEyeResult hand_eye = SolveHandEye(motions, rig.lidars[l].guess, 10.0 * kInterval);
    calibration.T_imu_sensor = hand_eye.valid
                                   ? hand_eye.T_imu_lidar
                                   : RigidTransform{alignment.R_imu_lidar, Eigen::Vector3d::Zero()};
    if (!hand_eye.valid) result.problems.push_back(rig.lidars[l].name + ": " + hand_eye.failure);
  }
  for (std::size_t l = 0; l < lidars; ++l) {
    if (!rig.lidars[l].fixed) continue;
    result.state.lidars[l].T_imu_sensor = rig.lidars[l].guess->T_imu_sensor;
    result.state.lidars[l].time_offset = rig.lidars[l].time_offset.value_or(0.0);
    result.state.lidars[l].clock_drift.reset();
  }
  return result;
}

}  // namespace mlic
