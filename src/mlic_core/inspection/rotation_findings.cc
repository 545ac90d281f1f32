#include "mlic_core/inspection/rotation_findings.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "mlic_core/common/angles.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/geometry/symmetric_matrix.h"
#include "mlic_core/imu/excitation.h"
#include "mlic_core/ingest/drive_notes.h"
#include "mlic_core/lidar/odometry.h"

namespace mlic {
namespace {

// from: definition, docs/inspection.md
constexpr double kFarFromGuess = 4.0;  // sigmas of the guess, beside those of the measurement
constexpr double kShortOdometry =
    0.5 / kDegreesPerRadian;       // rad; from: guard, odometry of a few seconds errs by less
constexpr double kUnshown = 10.0;  // rad; from: guard, sigma of what the motion does not show
// A rotation that fits must leave this much less of the distance in sigmas, squared. from: guard
constexpr double kMuchBetter = 4.0;

// Squared distance in sigmas of a guess and of the measurement, in the directions that the motion shows.
double SquaredDistance(const AngularRateAlignment& alignment, const Eigen::Quaterniond& guess,
                       const Eigen::Vector3d& sigma) {
  Eigen::Matrix3d covariance = sigma.cwiseAbs2().asDiagonal();
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d axis = alignment.information_directions.col(i);
    const double own = 1.0 / std::sqrt(std::max(1e-12, alignment.information_values[i]));
    const double shown = own < 0.1 * kUnshown ? std::max(kShortOdometry, own) : kUnshown;
    covariance += shown * shown * axis * axis.transpose();
  }
  const Eigen::Vector3d distance = Log(alignment.R_imu_lidar * guess.conjugate());
  return SquaredMahalanobis(covariance, distance);
}

double SquaredDistance(const LidarRotation& lidar, const ExtrinsicGuess& guess) {
  return SquaredDistance(lidar.alignment, guess.T_imu_sensor.rotation, guess.sigma_rotation);
}

// The LiDAR with whose guess this one's has to be exchanged for both to fit; nullptr for none.
const LidarRotation* FindExchanged(const std::vector<LidarRotation>& lidars, const LidarRotation& lidar) {
  const LidarRotation* best = nullptr;
  double least = SquaredDistance(lidar, *lidar.guess) / kMuchBetter;
  for (const LidarRotation& other : lidars) {
    if (&other == &lidar || !other.guess || !IsUsable(other.alignment)) continue;
    const double crossed = SquaredDistance(lidar, *other.guess);
    const double own = SquaredDistance(other, *other.guess), there = SquaredDistance(other, *lidar.guess);
    if (crossed < least && there < own) {
      least = crossed;
      best = &other;
    }
  }
  return best;
}

// What to make of a LiDAR that does not turn as its guess says.
std::string RemedyFor(const std::vector<LidarRotation>& lidars, const LidarRotation& lidar) {
  if (const LidarRotation* other = FindExchanged(lidars, lidar)) {
    return LookExchanged(lidar.name, other->name);
  }
  ExtrinsicGuess inverse = *lidar.guess;
  inverse.T_imu_sensor.rotation = inverse.T_imu_sensor.rotation.conjugate();
  if (SquaredDistance(lidar, inverse) * kMuchBetter < SquaredDistance(lidar, *lidar.guess)) {
    return "T_imu_sensor looks inverted: it maps points of the sensor into the IMU frame";
  }
  return "correct T_imu_sensor, or check that the topic is this sensor's";
}

Finding GuessFinding(const std::vector<LidarRotation>& lidars, const LidarRotation& lidar) {
  const double sigmas = std::sqrt(SquaredDistance(lidar, *lidar.guess));
  Finding finding{Grade::kPass,
                  lidar.name,
                  "rotation to the IMU",
                  Number(sigmas, "%.1f") + " sigmas off the rig file's T_imu_sensor, by " +
                      std::to_string(lidar.alignment.rotation_directions_shown) +
                      " directions that a few seconds show, offset " +
                      Number(1e3 * lidar.alignment.time_offset, "%.0f") + " ms",
                  Number(kFarFromGuess) + " sigmas",
                  ""};
  if (sigmas <= kFarFromGuess) return finding;
  finding.grade = Grade::kFail;
  finding.remedy = RemedyFor(lidars, lidar);
  return finding;
}

}  // namespace

TimeInterval LiveliestStretch(const std::vector<ImuSample>& imu, double length) {
  constexpr double kStep = 2.0;  // s; from: structural
  TimeInterval best{imu.front().time, std::min(imu.back().time, imu.front().time + length)};
  double most = -1.0;
  for (double start = imu.front().time; start + length <= imu.back().time; start += kStep) {
    std::vector<ImuSample> part;
    for (const ImuSample& s : imu) {
      if (s.time >= start && s.time < start + length) part.push_back(s);
    }
    if (part.size() < 4) continue;
    const Eigen::Vector3d rms = MeasureExcitation(part).principal_rms;
    if (rms[1] * rms[2] <= most) continue;
    most = rms[1] * rms[2];
    best = {start, start + length};
  }
  return best;
}

LidarRotation MeasureRotation(const LidarConfig& config, const LidarRecording& recording,
                              const std::vector<ImuSample>& imu, const CancellationToken& cancellation) {
  LidarRotation rotation{config.name, config.guess, {}, {}};
  const std::vector<TimedPose> poses = RunOdometry(recording, {}, kAllScans, cancellation, [](double) {});
  rotation.alignment = AlignAngularRates(imu, poses, std::nullopt);
  rotation.pose_information = MeasurePoseInformation(recording, poses);
  return rotation;
}

Findings RotationFindings(const std::vector<LidarRotation>& lidars) {
  Findings findings;
  for (const LidarRotation& lidar : lidars) {
    const AngularRateAlignment& alignment = lidar.alignment;
    const bool usable = IsUsable(alignment);
    std::string measured = "offset +- " + Number(1e3 * alignment.time_offset_sigma, "%.2g") + " ms, " +
                           Number(100.0 * alignment.inlier_share, "%.0f") +
                           " % of the poses agree, correlation " + Number(alignment.peak_correlation, "%.2f");
    if (!alignment.failure.empty()) measured = alignment.failure;
    findings.push_back({usable ? Grade::kPass : Grade::kWarn, lidar.name, "odometry beside the gyroscope",
                        measured, "offset within 50 ms, 30 % of the poses",
                        "turn more, among more structure; check that the topic is of this vehicle"});
    if (usable && lidar.guess) findings.push_back(GuessFinding(lidars, lidar));
  }
  return findings;
}

PoseNoise PoseNoiseOf(const std::vector<LidarRotation>& lidars) {
  PoseInformation sum = PoseInformation::Zero();
  bool any = false;
  for (const LidarRotation& lidar : lidars) {
    const bool shown = IsUsable(lidar.alignment) && lidar.alignment.rotation_directions_shown == 3;
    if (!lidar.pose_information || (!shown && !lidar.guess)) continue;
    PoseInformation turn = PoseInformation::Zero();
    turn.topLeftCorner<3, 3>() =
        (shown ? lidar.alignment.R_imu_lidar : lidar.guess->T_imu_sensor.rotation).toRotationMatrix();
    turn.bottomRightCorner<3, 3>() = turn.topLeftCorner<3, 3>();
    sum += turn * *lidar.pose_information * turn.transpose();
    any = true;
  }
  return any ? NoiseOfPoses(sum) : TypicalPoseNoise();
}

Findings FrameFindings(const std::vector<SensorFrame>& sensors) {
  Findings findings;
  for (const auto& [first, second] : ExchangedFrames(sensors)) {
    const SensorFrame &a = sensors[first], &b = sensors[second];
    for (const SensorFrame* sensor : {&a, &b}) {
      findings.push_back({Grade::kFail, sensor->name, "frame",
                          "its messages are in the frame " + sensor->found,
                          "the rig file's " + sensor->expected, LookExchanged(a.name, b.name)});
    }
  }
  return findings;
}

}  // namespace mlic
