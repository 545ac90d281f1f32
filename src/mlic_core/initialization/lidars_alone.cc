#include "mlic_core/initialization/lidars_alone.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <optional>

#include "mlic_core/common/order_statistics.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/initialization/guess_check.h"
#include "mlic_core/initialization/map_alignment.h"
#include "mlic_core/initialization/own_map.h"
#include "mlic_core/initialization/pose_fit.h"

namespace mlic {
namespace {

constexpr double kLargestRig = 6.0;  // m, between two LiDARs of one vehicle; from: guard
constexpr double kRate = 50.0;       // samples/s of the root's motion; from: structural
// rad/s and m/s^2 of such a sample. Scans show the motion a hundred times better. from: guard
constexpr double kLooseTurn = 0.3, kLooseForce = 3.0;
constexpr double kGivenOffset = 0.005;    // s; from: definition, the limit of what counts as shown
constexpr double kUnknownOffset = 0.035;  // s; from: derivation, a stamp is at start or end of a 0.1 s scan

// The root's extrinsic and its sigma are part of what is known of another sensor against it.
std::optional<ExtrinsicGuess> GuessAgainst(const std::optional<ExtrinsicGuess>& root,
                                           const std::optional<ExtrinsicGuess>& sensor) {
  if (!root || !sensor) return std::nullopt;
  const RigidTransform T_root_imu = root->T_imu_sensor.Inverse();
  const Eigen::Matrix3d R = T_root_imu.rotation.toRotationMatrix();
  const Eigen::Matrix3d arm = Hat(sensor->T_imu_sensor.translation - root->T_imu_sensor.translation);
  const auto squared = [](const Eigen::Vector3d& sigma) {
    return Eigen::Matrix3d(sigma.cwiseAbs2().asDiagonal());
  };
  const Eigen::Matrix3d of_root = squared(root->sigma_rotation);
  const Eigen::Matrix3d rotation = of_root + squared(sensor->sigma_rotation);
  const Eigen::Matrix3d translation =
      squared(root->sigma_translation) + squared(sensor->sigma_translation) + arm * of_root * arm.transpose();
  ExtrinsicGuess guess;
  guess.T_imu_sensor = T_root_imu * sensor->T_imu_sensor;
  guess.sigma_rotation = (R * rotation * R.transpose()).diagonal().cwiseSqrt();
  guess.sigma_translation = (R * translation * R.transpose()).diagonal().cwiseSqrt();
  return guess;
}

// Time offset of a LiDAR to the IMU before the maps are asked.
struct OffsetStart {
  double value = 0.0;  // s
  double sigma = 0.0;  // s; 0: the gyroscope shows it
};

OffsetStart OffsetOf(const LidarConfig& config, const AngularRateAlignment& alignment) {
  if (IsUsable(alignment)) return {alignment.time_offset, 0.0};
  if (config.time_offset) return {*config.time_offset, kGivenOffset};
  return {0.0, kUnknownOffset};
}

// What is known of each LiDAR, and then of each camera, against the root.
struct AgainstRoot {
  std::vector<std::optional<ExtrinsicGuess>> guesses;
  std::vector<OffsetStart> offsets;
};

AgainstRoot MakeAgainstRoot(const Rig& rig, const DriveOdometry& odometry, std::size_t root) {
  AgainstRoot against;
  const OffsetStart of_root = OffsetOf(rig.lidars[root], odometry.alignments[root]);
  for (std::size_t l = 0; l < rig.lidars.size(); ++l) {
    const OffsetStart own = OffsetOf(rig.lidars[l], odometry.alignments[l]);
    against.offsets.push_back({own.value - of_root.value, std::hypot(own.sigma, of_root.sigma)});
    against.guesses.push_back(GuessAgainst(rig.lidars[root].guess, rig.lidars[l].guess));
  }
  against.offsets[root] = {};
  for (const CameraConfig& camera : rig.cameras) {
    const OffsetStart own = camera.time_offset ? OffsetStart{*camera.time_offset, kGivenOffset}
                                               : OffsetStart{of_root.value, kUnknownOffset};
    against.offsets.push_back({own.value - of_root.value, std::hypot(own.sigma, of_root.sigma)});
    against.guesses.push_back(GuessAgainst(rig.lidars[root].guess, camera.guess));
  }
  return against;
}

std::size_t RichestMap(const std::vector<OwnMap>& maps) {
  const auto fewer = [](const OwnMap& x, const OwnMap& y) { return x.planes.size() < y.planes.size(); };
  return static_cast<std::size_t>(std::max_element(maps.begin(), maps.end(), fewer) - maps.begin());
}

std::string Describe(const std::string& name, const MapAlignment& found) {
  char line[200];
  std::snprintf(line, sizeof(line), "%s: %.0f %% of its planes lie on the others', at most %.0f %% elsewhere",
                name.c_str(), 100.0 * found.share, 100.0 * found.share_elsewhere);
  return line;
}

// Lays the maps into one another, each where it is clear: T_root_lidar of those.
std::vector<std::optional<RigidTransform>> LayMaps(const Rig& rig, const std::vector<OwnMap>& maps,
                                                   const AgainstRoot& against, std::size_t root,
                                                   const CancellationToken& cancellation,
                                                   std::vector<std::string>* notes) {
  std::vector<std::optional<RigidTransform>> found(maps.size());
  found[root] = RigidTransform{};
  std::vector<MapPlane> common = maps[root].planes;
  for (bool any = true; any;) {
    any = false;
    for (std::size_t l = 0; l < maps.size(); ++l) {
      if (found[l]) continue;
      cancellation.ThrowIfCancelled();
      const std::optional<ExtrinsicGuess>& guess = against.guesses[l];
      const auto plausible = [&](const RigidTransform& T) {
        return (guess ? !ContradictsGuess(*guess, T) : T.translation.norm() < kLargestRig) &&
               MovesAlike(maps[root].poses, maps[l].poses, against.offsets[l].value, T);
      };
      const auto starts = guess ? RotationsAbout(guess->T_imu_sensor, guess->sigma_rotation) : AllRotations();
      const std::optional<MapAlignment> alignment = AlignMaps(common, maps[l].planes, starts, plausible);
      if (!alignment) continue;
      notes->push_back(Describe(rig.lidars[l].name, *alignment));
      if (!alignment->IsClear()) continue;
      found[l] = alignment->T_a_b;
      const std::vector<MapPlane> more = MovedBy(*found[l], maps[l].planes);
      common.insert(common.end(), more.begin(), more.end());
      any = true;
    }
  }
  return found;
}

// The motion along the trajectory as an IMU in its frame would measure it.
std::vector<ImuSample> SamplesAlong(const SplitSpline& trajectory) {
  std::vector<ImuSample> samples;
  const int count = static_cast<int>((trajectory.End() - trajectory.Start()) * kRate);
  for (int k = 0; k < count; ++k) {
    const double t = trajectory.Start() + (k + 0.5) / kRate;
    const So3Spline::Value rotation =
        trajectory.rotation.Evaluate(SplineBasis(trajectory.rotation.knots(), t));
    const Eigen::Vector3d acceleration =
        trajectory.position.Acceleration(SplineBasis(trajectory.position.knots(), t));
    samples.push_back(
        {t, rotation.angular_velocity, rotation.rotation.transpose() * (acceleration - kGravity)});
  }
  return samples;
}

std::vector<TimedPose> PosesWithin(const TimeInterval& stretch, const std::vector<TimedPose>& poses) {
  std::vector<TimedPose> within;
  std::copy_if(poses.begin(), poses.end(), std::back_inserter(within),
               [&](const TimedPose& pose) { return stretch.Contains(pose.time); });
  return within;
}

// Without the IMU scans alone show the motion, and nothing faster than they come.
KnotSpacing SpacingOf(const std::vector<ImuSample>& imu, const std::vector<TimedPose>& poses) {
  const double finest = MedianPeriod(poses);
  const KnotSpacing measured = ChooseKnotSpacing(imu, finest);
  return {std::max(measured.rotation, finest), std::max(measured.position, finest)};
}

Rig RigAbout(const Rig& rig, const AgainstRoot& against, std::size_t root) {
  Rig about;
  about.imu.frame_id = rig.lidars[root].frame_id;
  about.imu.alignment_sigma = 0.0;  // the samples that stand for it are exact in this
  about.imu.gravity = kStandardGravity;
  about.lidars = rig.lidars;
  for (std::size_t l = 0; l < rig.lidars.size(); ++l) {
    about.lidars[l].guess = against.guesses[l];
    about.lidars[l].time_offset.reset();
    about.lidars[l].fixed = l == root;
  }
  about.lidars[root].guess = ExtrinsicGuess{};
  about.cameras = rig.cameras;
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    about.cameras[c].guess = against.guesses[rig.lidars.size() + c];
    about.cameras[c].time_offset = against.offsets[rig.lidars.size() + c].value;
    about.cameras[c].fixed = false;
  }
  return about;
}

}  // namespace

LidarsAlone InitializeLidarsAlone(const Rig& rig, const Dataset& dataset, const DriveOdometry& odometry,
                                  const CancellationToken& cancellation) {
  const Drive& drive = dataset.drives[0];
  const std::size_t lidars = rig.lidars.size();
  const UsedStretches stretches = ChooseStretches(odometry);
  LidarsAlone alone;
  alone.parked = stretches.parked;
  if (stretches.maps.Duration() <= 0.0) return alone;
  Drive& used = alone.dataset.drives.emplace_back();
  used.epoch = drive.epoch;
  used.lidars = ScansWithin(stretches.maps, drive);
  std::vector<OwnMap> maps;
  const double moment = 0.5 * (stretches.rounds.start + stretches.rounds.end);
  for (std::size_t l = 0; l < lidars; ++l) {
    cancellation.ThrowIfCancelled();
    // On the IMU's clock, or whichever the LiDARs share.
    const double offset = OffsetOf(rig.lidars[l], odometry.alignments[l]).value;
    maps.push_back(MakeOwnMap(used, l, odometry.lidars[l], moment - offset));
  }
  const std::size_t root = alone.root = RichestMap(maps);
  if (maps[root].planes.empty()) return alone;
  const AgainstRoot against = MakeAgainstRoot(rig, odometry, root);
  Initialization& start = alone.start;
  start.notes.push_back("about " + rig.lidars[root].name + ", which has the richest map");
  const auto found = LayMaps(rig, maps, against, root, cancellation, &start.notes);
  for (std::size_t l = 0; l < lidars; ++l) {
    alone.tied.push_back(found[l].has_value());
    start.state.lidars.push_back({found[l].value_or(RigidTransform{}), against.offsets[l].value});
    if (!found[l]) {
      start.problems.push_back(rig.lidars[l].name +
                               ": its map is not found in the others' at one clear place; drive, so that one "
                               "LiDAR sees what another has seen, or give T_imu_sensor of both");
    }
  }
  for (const OffsetStart& offset : against.offsets) alone.time_offset_sigmas.push_back(offset.sigma);
  alone.rig = RigAbout(rig, against, root);
  const bool camera = std::any_of(alone.rig.cameras.begin(), alone.rig.cameras.end(),
                                  [](const CameraConfig& config) { return config.guess.has_value(); });
  if (std::count(alone.tied.begin(), alone.tied.end(), true) < 2 && !camera) return alone;
  start.base_lidar = root;
  start.unaligned.assign(lidars, false);
  start.imu_sigma = {{Eigen::Vector3d::Constant(kLooseTurn), Eigen::Vector3d::Constant(kLooseForce)}};
  used.lidars = ScansWithin(stretches.rounds, drive);
  used.cameras = drive.cameras;
  const std::vector<TimedPose> poses = PosesWithin(stretches.rounds, maps[root].poses);
  SplitSpline& trajectory = start.state.drives.emplace_back().trajectory;
  trajectory = SplineThrough(poses, SpacingOf(drive.imu, poses));
  used.imu = SamplesAlong(trajectory);
  return alone;
}

}  // namespace mlic
