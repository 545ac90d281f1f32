#pragma once

#include <cmath>
#include <functional>
#include <vector>

#include "mlic_core/problem/joint_problem.h"
#include "mlic_core/problem/state.h"
#include "mlic_core/sensors/measurements.h"
#include "mlic_sim/motions.h"
#include "support/synthetic_tracks.h"
#include "support/true_spline.h"

namespace mlic {

// A camera and an IMU by hand, at the truth, with white noise beside what errors are given.
struct CameraWithImu {
  Dataset dataset;
  CalibrationState state;
  std::vector<TrackSet> tracks;
  ImuSigma imu_sigma;
};

constexpr double kCameraWithImuDuration = 18.0;  // s

// An error of an observation that is not white, px, by its time and pixel.
using CommonError = std::function<Eigen::Vector2d(double, const Eigen::Vector2d&)>;
inline Eigen::Vector2d NoCommonError(double, const Eigen::Vector2d&) { return Eigen::Vector2d::Zero(); }

inline CameraCalibration CameraOfCameraWithImu() {
  CameraCalibration camera;
  camera.sensor = {{FromRollPitchYaw(M_PI / 180.0 * Eigen::Vector3d(-91.0, 1.0, -89.0)), {0.06, 0.11, -0.01}},
                   -0.02};
  camera.intrinsics = {
      CameraModel::kPlumbBob, 752, 480, {392.0, 391.0, 371.0, 244.0, -0.09, 0.018, 0.0004, -0.0006, -0.001}};
  return camera;
}

inline CameraWithImu MakeCamerasWithImu(const std::vector<CameraCalibration>& cameras, std::uint64_t seed,
                                        int points, const CommonError& common) {
  constexpr double kImuRate = 200.0;
  constexpr double kGyroscope = 2e-4, kAccelerometer = 2e-3;  // densities
  constexpr double kPixel = 0.3;                              // px
  CameraWithImu c;
  const auto trajectory =
      sim::MakeTrajectory(sim::Scenario::kHandheld, seed, kCameraWithImuDuration, RigidTransform());
  DriveState drive;
  drive.trajectory = TrueSpline(*trajectory, kCameraWithImuDuration, kSyntheticKnots);
  c.state.drives.push_back(drive);
  c.state.cameras = cameras;
  SyntheticTracksOptions options;
  options.duration = kCameraWithImuDuration;
  options.points = points;
  options.seed = seed;
  options.visible_seconds = 0.8;
  c.tracks.push_back(MakeTracks(drive.trajectory, c.state.cameras, options));
  Random random(seed + 50);
  for (Track& track : c.tracks[0].tracks) {
    for (TrackObservation& o : track.observations) {
      const double time = c.tracks[0].keyframes[o.keyframe].time;
      o.pixel += common(time, o.pixel.cast<double>()).cast<float>() +
                 kPixel * Eigen::Vector2f(random.Normal(), random.Normal());
      o.sigma = kPixel;
    }
  }
  c.imu_sigma.gyroscope.setConstant(kGyroscope * std::sqrt(kImuRate));
  c.imu_sigma.accelerometer.setConstant(kAccelerometer * std::sqrt(kImuRate));
  c.dataset.drives.emplace_back();
  const auto noise = [&](double density) {
    const double x = random.Normal(), y = random.Normal(), z = random.Normal();
    return Eigen::Vector3d(density * std::sqrt(kImuRate) * Eigen::Vector3d(x, y, z));
  };
  for (int i = 0; i <= static_cast<int>(kCameraWithImuDuration * kImuRate); ++i) {
    const double t = i / kImuRate;
    const SplineBasis basis(drive.trajectory.position.knots(), t);
    c.dataset.drives[0].imu.push_back({t, drive.trajectory.rotation.AngularVelocity(t) + noise(kGyroscope),
                                       drive.trajectory.rotation.Rotation(t).conjugate() *
                                               (drive.trajectory.position.Acceleration(basis) - kGravity) +
                                           noise(kAccelerometer)});
  }
  return c;
}

// readout: s, of a rolling shutter; 0: a global one.
inline CameraWithImu MakeCameraWithImu(std::uint64_t seed, int points, const CommonError& common,
                                       double readout = 0.0) {
  CameraCalibration camera = CameraOfCameraWithImu();
  camera.readout = readout;
  camera.rolling_shutter = readout > 0.0;
  return MakeCamerasWithImu({camera}, seed, points, common);
}

}  // namespace mlic
