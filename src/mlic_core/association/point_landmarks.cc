#include "mlic_core/association/point_landmarks.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "mlic_core/association/landmark_noise.h"
#include "mlic_core/camera/two_view/triangulation.h"
#include "mlic_core/common/parallel.h"

namespace mlic {
namespace {

// Pixels that a camera's image moves by for each radian of a bearing's turn, in the mean over directions.
double PixelsPerRadian(const CameraIntrinsics& intrinsics, const Eigen::Vector3d& bearing) {
  Eigen::Vector2d pixel;
  CameraPointJacobian J;
  if (!Project(intrinsics, bearing, &pixel, &J)) return 0.0;
  const Eigen::Vector3d u = bearing.unitOrthogonal();
  Eigen::Matrix2d turn;
  turn << J * u, J * bearing.cross(u);
  return std::sqrt(std::abs(turn.determinant()));
}

// One bearing of a track, in the map; nothing where the trajectory or the camera model does not reach.
std::optional<BearingObservation> BearingOf(const LandmarkObservation& o, const CameraCalibration& camera,
                                            const SplitSpline& trajectory) {
  const double t = camera.sensor.OnImuClock(o.time, trajectory.Middle()) +
                   o.pixel.y() / camera.intrinsics.height * camera.readout;
  Eigen::Vector3d bearing;
  if (!trajectory.Contains(t) || !Unproject(camera.intrinsics, o.pixel, &bearing)) return std::nullopt;
  const double scale = PixelsPerRadian(camera.intrinsics, bearing);
  if (scale < 1.0) return std::nullopt;
  const RigidTransform T_map_camera = trajectory.Pose(t) * camera.sensor.T_imu_sensor;
  return BearingObservation{T_map_camera.translation, T_map_camera.rotation * bearing, o.sigma / scale};
}

// By how much a landmark's noise differs from what its bearings claim, given their whitened errors: the scale
// that makes normal errors Student's t with kPriorFreedom (Lange, Little and Taylor, JASA 1989).
double OwnNoise(const TriangulatedPoint& point) {
  const double freedom = LandmarkFreedom(static_cast<std::size_t>(point.inliers));
  return std::sqrt((kPriorFreedom + freedom * point.rms * point.rms) / (kPriorFreedom + freedom));
}

struct Landmark {
  PointLandmark point;
  std::vector<LandmarkObservation> observations;
};

Landmark Triangulate(const TrackSet& tracks, const Track& track, const CalibrationState& state,
                     std::size_t drive, const LandmarkOptions& options) {
  Landmark landmark;
  std::vector<BearingObservation> bearings;
  for (const TrackObservation& seen : track.observations) {
    const Keyframe& keyframe = tracks.keyframes[seen.keyframe];
    const double spread = options.noise.empty() ? 1.0 : options.noise[keyframe.camera].spread;
    const double sigma = std::max(options.least_sigma, spread * seen.sigma);
    const LandmarkObservation o{keyframe.camera, static_cast<float>(sigma), keyframe.time,
                                seen.pixel.cast<double>()};
    const auto bearing = BearingOf(o, state.cameras[o.camera], state.drives[drive].trajectory);
    if (!bearing) continue;
    bearings.push_back(*bearing);
    landmark.observations.push_back(o);
  }
  TriangulationOptions triangulation;
  triangulation.largest_error = options.largest_error;
  triangulation.least_parallax_deg = options.least_parallax_deg;
  const auto point = bearings.size() < 2 ? std::nullopt : TriangulatePoint(bearings, triangulation);
  std::vector<LandmarkObservation> agreeing;
  landmark.point.anchor.setZero();
  for (std::size_t k = 0; k < bearings.size() && point; ++k) {
    if (!point->inlier[k]) continue;
    agreeing.push_back(landmark.observations[k]);
    landmark.point.anchor += bearings[k].centre;
  }
  landmark.observations = std::move(agreeing);
  if (!point) return landmark;
  const double own =
      options.noise_of_each ? OwnNoise(*point) * ManyObservationsScale(landmark.observations.size()) : 1.0;
  for (LandmarkObservation& o : landmark.observations) {
    o.sigma *= static_cast<float>(own * (options.noise.empty() ? 1.0 : options.noise[o.camera].dependence));
  }
  landmark.point.position = point->position;
  landmark.point.anchor /= static_cast<double>(landmark.observations.size());
  return landmark;
}

}  // namespace

LandmarkSet TriangulateLandmarks(const TrackSet& tracks, const CalibrationState& state, std::size_t drive,
                                 const LandmarkOptions& options) {
  std::vector<Landmark> landmarks(tracks.tracks.size());
  ParallelFor(tracks.tracks.size(), [&](std::size_t i) {
    landmarks[i] = Triangulate(tracks, tracks.tracks[i], state, drive, options);
  });
  std::vector<std::size_t> order(landmarks.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return landmarks[a].observations.size() > landmarks[b].observations.size();
  });
  if (order.size() > options.most_points) order.resize(options.most_points);
  std::sort(order.begin(), order.end());
  LandmarkSet set;
  set.begin.push_back(0);
  for (const std::size_t i : order) {
    if (landmarks[i].observations.size() < 2) continue;
    set.points.push_back(landmarks[i].point);
    set.observations.insert(set.observations.end(), landmarks[i].observations.begin(),
                            landmarks[i].observations.end());
    set.begin.push_back(set.observations.size());
  }
  return set;
}

std::vector<TrackSet> WithoutLostCameras(std::vector<TrackSet> tracks, const std::vector<bool>& found) {
  for (TrackSet& set : tracks) {
    for (Track& track : set.tracks) {
      auto& seen = track.observations;
      seen.erase(
          std::remove_if(seen.begin(), seen.end(),
                         [&](const TrackObservation& o) { return !found[set.keyframes[o.keyframe].camera]; }),
          seen.end());
    }
  }
  return tracks;
}

std::vector<std::size_t> CountObservations(const std::vector<LandmarkSet>& landmarks, std::size_t cameras) {
  std::vector<std::size_t> counts(cameras, 0);
  for (const LandmarkSet& set : landmarks) {
    for (const LandmarkObservation& o : set.observations) ++counts[o.camera];
  }
  return counts;
}

}  // namespace mlic
