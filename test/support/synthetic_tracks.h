#pragma once

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "mlic_core/camera/tracks/tracks.h"
#include "mlic_core/common/random.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/initialization/camera_on_trajectory.h"
#include "mlic_core/problem/state.h"
#include "mlic_sim/trajectory.h"

namespace mlic {

// Tracks of random points seen by cameras whose truth is known, from a trajectory that is itself a spline, so
// that without noise nothing but rounding is left.
struct SyntheticTracksOptions {
  double duration = 30.0;
  double keyframe_period = 0.25;  // s; of each camera, with phases of their own
  int points = 6000;
  double nearest = 1.5, farthest = 8.0;  // m, from the place where a point is drawn
  double visible_seconds = 1.2;          // either side of the time where a point is drawn
  double noise = 0.0;                    // px
  double outliers = 0.0;                 // share of observations that lie anywhere in the image
  std::uint64_t seed = 1;
};

constexpr double kSyntheticKnots = 0.05;  // s, between those of the splines that the tracks are made from

// The pixel of a point in an image with this stamp; false where it is not in the image.
inline bool See(const SplitSpline& trajectory, const CameraCalibration& camera, double stamp,
                const Eigen::Vector3d& point, Eigen::Vector2d* pixel) {
  const CameraIntrinsics& intrinsics = camera.intrinsics;
  double row = 0.5 * intrinsics.height;
  for (int iteration = 0; iteration < 8; ++iteration) {
    const double t = stamp + camera.sensor.time_offset + row / intrinsics.height * camera.readout;
    if (!trajectory.Contains(t)) return false;
    const RigidTransform T = trajectory.Pose(t) * camera.sensor.T_imu_sensor;
    if (!Project(intrinsics, T.Inverse() * point, pixel)) return false;
    row = pixel->y();
  }
  return pixel->x() > 0.0 && pixel->y() > 0.0 && pixel->x() < intrinsics.width - 1.0 &&
         pixel->y() < intrinsics.height - 1.0;
}

inline TrackSet MakeTracks(const SplitSpline& trajectory, const std::vector<CameraCalibration>& cameras,
                           const SyntheticTracksOptions& options) {
  TrackSet tracks;
  Random random(options.seed);
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    const double phase = random.Uniform() * options.keyframe_period;
    for (double t = phase; t < options.duration; t += options.keyframe_period) {
      tracks.keyframes.push_back(
          {static_cast<int>(c), 0, t + 0.1 * options.keyframe_period * random.Uniform()});
    }
  }
  for (int p = 0; p < options.points; ++p) {
    const double when = random.Uniform(0.0, options.duration);
    const Eigen::Vector3d direction =
        Eigen::Vector3d(random.Normal(), random.Normal(), random.Normal()).normalized();
    const Eigen::Vector3d point =
        trajectory.Pose(when).translation + random.Uniform(options.nearest, options.farthest) * direction;
    Track track;
    for (std::size_t k = 0; k < tracks.keyframes.size(); ++k) {
      const Keyframe& keyframe = tracks.keyframes[k];
      Eigen::Vector2d pixel;
      if (std::abs(keyframe.time - when) > options.visible_seconds) continue;
      if (!See(trajectory, cameras[keyframe.camera], keyframe.time, point, &pixel)) continue;
      pixel += options.noise * Eigen::Vector2d(random.Normal(), random.Normal());
      if (random.Uniform() < options.outliers) {
        const CameraIntrinsics& intrinsics = cameras[keyframe.camera].intrinsics;
        pixel = {random.Uniform(0.0, intrinsics.width - 1.0), random.Uniform(0.0, intrinsics.height - 1.0)};
      }
      track.observations.push_back({static_cast<std::int32_t>(k), pixel.cast<float>(),
                                    static_cast<float>(options.noise > 0.0 ? options.noise : 0.5)});
    }
    if (track.observations.size() >= 2) tracks.tracks.push_back(track);
  }
  return tracks;
}

// The rig file and the starts of cameras whose intrinsics are known, and nothing else of them.
inline Rig RigOf(const std::vector<CameraCalibration>& cameras) {
  Rig rig;
  for (const CameraCalibration& camera : cameras) {
    CameraConfig config;
    config.name = "camera_" + std::to_string(rig.cameras.size());
    config.model = camera.intrinsics.model;
    config.shutter = camera.rolling_shutter ? Shutter::kRolling : Shutter::kGlobal;
    rig.cameras.push_back(config);
  }
  return rig;
}
inline std::vector<CameraStart> StartsOf(const std::vector<CameraCalibration>& cameras) {
  std::vector<CameraStart> starts;
  for (const CameraCalibration& camera : cameras) starts.push_back({camera.intrinsics, false});
  return starts;
}

// Mean displacement over the image between two intrinsics, px; no rotation is taken out.
inline double MeanDisplacement(const CameraIntrinsics& truth, const CameraIntrinsics& estimate) {
  double sum = 0.0;
  int count = 0;
  for (int i = 0; i < 400; ++i) {
    Eigen::Vector3d bearing;
    Eigen::Vector2d pixel((i % 20 + 0.5) / 20.0 * truth.width, (i / 20 + 0.5) / 20.0 * truth.height), other;
    if (!Unproject(truth, pixel, &bearing) || !Project(estimate, bearing, &other)) continue;
    sum += (pixel - other).norm();
    ++count;
  }
  return sum / count;
}

}  // namespace mlic
