#include "mlic_core/initialization/drive_odometry.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <utility>

#include "mlic_core/common/parallel.h"
#include "mlic_core/geometry/symmetric_matrix.h"
#include "mlic_core/initialization/inertial_motion.h"

namespace mlic {
namespace {

constexpr double kLeastInlierShare = 0.1;  // of inliers; from: guard, division by it
constexpr double kFollowed = 5e-3;         // rad, of scans that are followed; from: guard, they err by 1 mrad
constexpr std::size_t kFewScans = 20;      // from: structural, 2 s of the alignment's segments at 10 Hz

std::optional<RotationGuess> GuessOfRotation(const LidarConfig& lidar) {
  if (!lidar.guess) return std::nullopt;
  return RotationGuess{lidar.guess->T_imu_sensor.rotation, lidar.guess->sigma_rotation};
}

// With the guess; where nothing fits it, the guess is worse than it claims and counts for little. Where it is
// worse still, as a transform that was given the wrong way round, and the motion shows all of the rotation,
// it is dropped.
AngularRateAlignment Align(const Drive& drive, const std::vector<TimedPose>& odometry,
                           std::optional<RotationGuess>* guess) {
  constexpr double kVague = 30.0 * M_PI / 180.0;  // from: guard, wider than any guess
  const AngularRateAlignment alignment = AlignAngularRates(drive.imu, odometry, *guess);
  if (!*guess || IsUsable(alignment)) return alignment;
  RotationGuess vague = **guess;
  vague.sigma = vague.sigma.cwiseMax(kVague);
  const AngularRateAlignment nearly = AlignAngularRates(drive.imu, odometry, vague);
  if (IsUsable(nearly)) {
    *guess = vague;
    return nearly;
  }
  const AngularRateAlignment without = AlignAngularRates(drive.imu, odometry, std::nullopt);
  if (!IsUsable(without) || without.rotation_directions_shown < 3) return alignment;
  guess->reset();
  return without;
}

// The drift is shown, and no time offset is right for all of the drive. A smaller one the joint rounds find.
bool DriftsGrossly(const AngularRateAlignment& alignment, const std::vector<TimedPose>& odometry) {
  constexpr double kSigmas = 5.0;  // from: guard, the joint rounds test it more strictly
  constexpr double kGross = 1e-3;  // s, at both ends; from: guard, joint rounds converge from ten times that
  const double half = 0.5 * (odometry.back().time - odometry.front().time);
  return alignment.valid && std::abs(alignment.clock_drift) > kSigmas * alignment.clock_drift_sigma &&
         std::abs(alignment.clock_drift) * half > kGross;
}

// The alignment of the poses once the drift of their clock is taken out of their times. A large one hides a
// part of itself, so it is looked for again. Where the poses agree no better then, they and the clock stay as
// they are.
AngularRateAlignment AlignWithDrift(const Drive& drive, std::vector<TimedPose>* odometry,
                                    std::optional<RotationGuess>* guess, ClockDrift* clock) {
  constexpr int kRounds = 4;  // from: guard
  const AngularRateAlignment constant = Align(drive, *odometry, guess);
  if (!DriftsGrossly(constant, *odometry)) return constant;
  AngularRateAlignment alignment = constant;
  std::vector<TimedPose> poses = *odometry;
  ClockDrift total = *clock;
  for (int round = 0; round < kRounds && DriftsGrossly(alignment, poses); ++round) {
    const ClockDrift step{alignment.clock_drift, total.middle};
    for (TimedPose& pose : poses) pose.time = step.Without(pose.time);
    total.drift += step.drift * (1.0 + total.drift);
    alignment = Align(drive, poses, guess);
  }
  if (!IsUsable(alignment) ||
      alignment.residual_rms * constant.inlier_share > constant.residual_rms * alignment.inlier_share) {
    return constant;
  }
  *odometry = std::move(poses);
  *clock = total;
  return alignment;
}

// Whether motion or guess show the rotation so well that the gyroscope predicts the LiDAR's turning better
// than what it did before.
bool PredictsTurning(const AngularRateAlignment& alignment) {
  constexpr double kSigma = 5.0 * M_PI / 180.0;  // from: guard, errs by a tenth of the turning
  if (alignment.rotation_directions_shown >= 2) return true;
  const SymmetricEigen<3> solver(alignment.rotation_covariance);
  return solver.eigenvalues()[2] < kSigma * kSigma;
}

// The rotations' part of Disagreement, rad.
double RotationDisagreement(const AngularRateAlignment& alignment) {
  if (!alignment.valid) return std::numeric_limits<double>::infinity();
  return alignment.residual_rms / std::max(kLeastInlierShare, alignment.inlier_share);
}

// The positions' part of Disagreement, m.
double PositionDisagreement(const GravityLeverArm& arm) {
  constexpr double kUnknown = 1.0;  // m; from: guard, residuals are some centimetres
  return arm.valid ? arm.residual_rms / std::max(kLeastInlierShare, arm.inlier_share) : kUnknown;
}

// One LiDAR's odometry in one drive, again and again with what the alignment with the IMU told.
class Follower {
 public:
  using Run = std::function<std::vector<TimedPose>(const InertialMotion&, std::size_t remembered)>;

  Follower(const Drive& drive, const LidarConfig& lidar, Run run)
      : drive_(&drive),
        rotation_guess_(GuessOfRotation(lidar)),
        lever_arm_guess_(LeverArmGuessOf(lidar)),
        run_(std::move(run)) {}

  void Follow() {
    std::vector<TimedPose> first = run_({}, kAllScans);
    if (!first.empty()) clock.middle = 0.5 * (first.front().time + first.back().time);
    Take(std::move(first));
    if (RotationDisagreement(alignment) > kFollowed) ForgetSoon();
    if (!IsUsable(alignment)) FollowGuess();
    if (!IsUsable(alignment) || !PredictsTurning(alignment)) return;
    Take(run_(RotationByImu(drive_->imu, alignment, clock), kAllScans));
    if (IsUsable(alignment)) FollowAccelerations();
  }

  std::vector<TimedPose> poses;
  AngularRateAlignment alignment;
  ClockDrift clock;

 private:
  void Take(std::vector<TimedPose> fresh) {
    poses = std::move(fresh);
    for (TimedPose& pose : poses) pose.time = clock.Without(pose.time);
    alignment = AlignWithDrift(*drive_, &poses, &rotation_guess_, &clock);
  }

  GravityLeverArm Arm() const {
    return SolveGravityLeverArm(drive_->imu, poses, alignment.R_imu_lidar, alignment.time_offset,
                                alignment.gyroscope_bias, lever_arm_guess_, alignment.rotation_covariance);
  }

  // Without the scans that went wrong in the map more of the others can be followed.
  void ForgetSoon() {
    Follower next = *this;
    next.Take(run_({}, kFewScans));
    if (RotationDisagreement(next.alignment) < RotationDisagreement(alignment)) *this = std::move(next);
  }

  // Predicted by the gyroscope, with the guess of the rotation and no time offset, which is right to some
  // degrees where a constant velocity is not.
  void FollowGuess() {
    if (!rotation_guess_) return;
    AngularRateAlignment assumed;
    assumed.R_imu_lidar = rotation_guess_->R_imu_lidar;
    for (const std::size_t remembered : {kAllScans, kFewScans}) {
      Follower next = *this;
      next.Take(run_(RotationByImu(drive_->imu, assumed, clock), remembered));
      if (RotationDisagreement(next.alignment) < RotationDisagreement(alignment)) *this = std::move(next);
      if (RotationDisagreement(alignment) <= kFollowed) return;
    }
  }

  // Each run corrects what the next stands on: gravity, lever arm, rotation and offset.
  void FollowAccelerations() {
    constexpr int kMostRuns = 4;     // from: guard, time
    constexpr double kSlips = 5e-3;  // m; from: guard, scans that are followed err by 1 to 2 mm
    constexpr double kBetter = 0.7;  // from: guard, of the disagreement before
    GravityLeverArm arm = Arm();
    for (int i = 0; i < kMostRuns && arm.valid && PositionDisagreement(arm) > kSlips; ++i) {
      Follower next = *this;
      next.Take(run_(MotionByImu(drive_->imu, alignment, arm, clock), kAllScans));
      if (!IsUsable(next.alignment)) return;
      const GravityLeverArm next_arm = next.Arm();
      const double before = Disagreement(alignment, arm), after = Disagreement(next.alignment, next_arm);
      if (after >= before) return;
      *this = std::move(next);
      if (after > kBetter * before) return;
      arm = next_arm;
    }
  }

  const Drive* drive_;
  std::optional<RotationGuess> rotation_guess_;
  std::optional<LeverArmGuess> lever_arm_guess_;
  Run run_;
};

}  // namespace

DriveOdometry RunDriveOdometry(const Rig& rig, const Drive& drive, const CancellationToken& cancellation,
                               const std::function<void(double)>& on_progress) {
  const std::size_t count = drive.lidars.size();
  DriveOdometry result;
  result.lidars.resize(count);
  result.alignments.resize(count);
  result.clocks.resize(count);
  std::vector<std::atomic<double>> parts(count);
  ParallelFor(count, [&](std::size_t l) {
    int runs = 0;
    Follower follower(drive, rig.lidars[l], [&](const InertialMotion& inertial, std::size_t remembered) {
      ++runs;
      return RunOdometry(drive.lidars[l], inertial, remembered, cancellation, [&](double fraction) {
        // Each run of those that are still to come, at least one, takes as long.
        parts[l] = 1.0 - std::pow(0.5, runs - 1) * (1.0 - 0.5 * fraction);
        double sum = 0.0;
        for (const auto& part : parts) sum += part;
        on_progress(sum / static_cast<double>(count));
      });
    });
    follower.Follow();
    result.lidars[l] = std::move(follower.poses);
    result.alignments[l] = std::move(follower.alignment);
    result.clocks[l] = follower.clock;
  });
  return result;
}

std::optional<LeverArmGuess> LeverArmGuessOf(const LidarConfig& lidar) {
  if (!lidar.guess) return std::nullopt;
  return LeverArmGuess{lidar.guess->T_imu_sensor.translation, lidar.guess->sigma_translation};
}

double Disagreement(const AngularRateAlignment& alignment, const GravityLeverArm& arm) {
  return PositionDisagreement(arm) * RotationDisagreement(alignment);
}

}  // namespace mlic
