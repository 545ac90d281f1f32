#include "mlic_core/initialization/camera_imu/rotations.h"

#include <algorithm>

#include "mlic_core/geometry/so3.h"
#include "mlic_core/imu/excitation.h"
#include "mlic_core/imu/gyro_integration.h"
#include "mlic_core/imu/robust.h"

namespace mlic {
namespace {

// from: guard, half of the finest knots of the trajectory.
constexpr double kSpacing = 0.02;  // s, of knots that follow the gyroscope
constexpr int kTurns = 2;          // of alignment and bias; from: guard

// The gyroscope's rotation as a trajectory that stands still.
SplitSpline GyroTrajectory(const GyroIntegration& gyro) {
  const UniformKnots knots = UniformKnots::Covering(gyro.Start(), gyro.End(), kSpacing);
  std::vector<Eigen::Quaterniond> rotations;
  for (int j = 0; j < knots.count; ++j) rotations.push_back(gyro.RotationTo(knots.ControlPointTime(j)));
  const std::vector<Eigen::Vector3d> positions(knots.count, Eigen::Vector3d::Zero());
  return {So3Spline(knots, rotations), PositionSpline(knots, positions)};
}

// The part of the bias that is left, from what the rotations of one drive disagree by. Robust; zero for none.
Eigen::Vector3d BiasLeft(const GyroIntegration& gyro, std::size_t drive, const std::vector<bool>& found,
                         const std::vector<CameraCalibration>& cameras,
                         const std::vector<std::vector<VisualMotion>>& motions) {
  struct Disagreement {
    Eigen::Vector3d angle;  // rad
    double duration;        // s
  };
  std::vector<Disagreement> all;
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    if (!found[c]) continue;
    const SensorCalibration& sensor = cameras[c].sensor;
    const Eigen::Quaterniond& R = sensor.T_imu_sensor.rotation;
    for (const VisualMotion& motion : motions[c]) {
      const double a = motion.time_a + sensor.time_offset, b = motion.time_b + sensor.time_offset;
      if (motion.drive != drive || !gyro.Covers(a, b)) continue;
      const Eigen::Quaterniond seen = R * Eigen::Quaterniond(motion.R_a_b) * R.conjugate();
      all.push_back({Log(Eigen::Quaterniond(seen.conjugate() * gyro.RotationBetween(a, b))), b - a});
    }
  }
  Eigen::Vector3d bias = Eigen::Vector3d::Zero();
  for (int iteration = 0; iteration < 10 && !all.empty(); ++iteration) {
    std::vector<double> norms;
    for (const Disagreement& d : all) norms.push_back((d.angle - d.duration * bias).norm());
    const double sigma = std::max(1e-5, SigmaFromNorms(norms));
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double weights = 1e-12;
    for (std::size_t k = 0; k < all.size(); ++k) {
      const double weight = iteration < 4 ? AbsoluteWeight(norms[k], sigma) : TukeyWeight(norms[k], sigma);
      sum += weight * all[k].duration * all[k].angle;
      weights += weight * all[k].duration * all[k].duration;
    }
    bias = sum / weights;
  }
  return bias;
}

}  // namespace

VisualRotations AlignWithGyroscope(const Rig& rig, const Dataset& dataset,
                                   const std::vector<CameraStart>& start, const std::vector<TrackSet>& tracks,
                                   const CancellationToken& cancellation) {
  const std::size_t cameras = rig.cameras.size();
  VisualRotations result;
  for (const Drive& drive : dataset.drives) {
    const ImuNoise noise = rig.imu.noise ? *rig.imu.noise : EstimateImuNoise(drive.imu);
    result.gyroscope_bias.push_back(MeanAngularVelocity(drive.imu, StaticIntervals(drive.imu, noise)));
  }
  std::vector<std::vector<PixelMatches>> pairs;
  for (std::size_t c = 0; c < cameras; ++c) pairs.push_back(MatchesOfKeyframes(tracks, static_cast<int>(c)));
  std::vector<CameraAlignment> alignments(cameras);
  for (int turn = 0; turn <= kTurns; ++turn) {
    std::vector<GyroIntegration> gyro;
    std::vector<SplitSpline> splines;
    std::vector<const SplitSpline*> trajectories;
    for (std::size_t d = 0; d < dataset.drives.size(); ++d) {
      gyro.emplace_back(dataset.drives[d].imu, result.gyroscope_bias[d]);
      splines.push_back(GyroTrajectory(gyro.back()));
    }
    for (const SplitSpline& spline : splines) trajectories.push_back(&spline);
    result.cameras.clear();
    result.found.assign(cameras, false);
    result.open.assign(cameras, false);
    result.offset_sigmas.assign(cameras, 0.0);
    result.notes.clear();
    result.problems.clear();
    std::vector<std::vector<VisualMotion>> motions(cameras);
    for (std::size_t c = 0; c < cameras; ++c) {
      cancellation.ThrowIfCancelled();
      const CameraConfig& config = rig.cameras[c];
      result.cameras.push_back(CameraAsGiven(config, start[c]));
      CameraCalibration& camera = result.cameras.back();
      result.found[c] =
          config.fixed || AlignCamera(config, start[c], pairs[c], trajectories, &camera, &alignments[c]);
      if (!result.found[c]) {
        result.problems.push_back({config.name, AlignmentProblem(config.name)});
      } else {
        if (!config.fixed) result.notes.push_back(AlignmentNote(config.name, camera, alignments[c].rotation));
        result.offset_sigmas[c] = config.fixed ? 0.0 : alignments[c].rotation.offset_sigma;
        result.open[c] = !config.fixed && !config.guess && alignments[c].rotation.weakest_axis < kWeakAxis;
        motions[c] = VisualMotions(pairs[c], camera.intrinsics, start[c].from_field_of_view ? 8.0 : 3.0);
      }
    }
    if (turn == kTurns) break;
    for (std::size_t d = 0; d < dataset.drives.size(); ++d) {
      result.gyroscope_bias[d] += BiasLeft(gyro[d], d, result.found, result.cameras, motions);
    }
  }
  return result;
}

}  // namespace mlic
