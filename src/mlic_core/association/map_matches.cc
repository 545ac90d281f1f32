#include "mlic_core/association/map_matches.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "mlic_core/association/ring_corrections.h"
#include "mlic_core/camera/features/image_quality.h"
#include "mlic_core/common/parallel.h"
#include "mlic_core/crossmodal/cross_modal_matches.h"
#include "mlic_core/crossmodal/nid.h"
#include "mlic_core/crossmodal/pnp.h"
#include "mlic_core/crossmodal/view_matcher.h"
#include "mlic_core/crossmodal/view_selection.h"
#include "mlic_core/problem/landmark_terms.h"

namespace mlic {
namespace {

// A map whose returns are many pixels apart, or noisy in intensity, shows little at full resolution. At a
// coarser level a pixel averages more of it. With fewer matches in a photo the next level is tried.
constexpr int kCoarsestLevel = 2;  // from: measured, kitti_0005: a quarter of the resolution finds matches
// from: guard, the car has 268 in a photo at full resolution, kitti_0005 has 0.1.
constexpr std::size_t kFewestInPhoto = 15;  // in the mean over a camera's photos of one window

// One photo that is matched to a window's map, and what came of it.
struct Photo {
  std::size_t drive = 0;
  int camera = 0;
  std::size_t image = 0;
  double time = 0.0;  // camera clock
  ViewPose pose;
  std::vector<MapMatch> matches;
  std::vector<PointOrigin> origins;  // of the matches
  double nid = 1.0;
};

std::vector<TimeInterval> WindowsOf(const SplitSpline& trajectory, double length) {
  const double span = trajectory.End() - trajectory.Start();
  const int count = std::max(1, static_cast<int>(std::lround(span / length)));
  std::vector<TimeInterval> windows;
  for (int w = 0; w < count; ++w) {
    windows.push_back({trajectory.Start() + span * w / count, trajectory.Start() + span * (w + 1) / count});
  }
  return windows;
}

// The photos of one camera in a window that say most about it.
std::vector<Photo> ChoosePhotos(const TrackSet& tracks, const CalibrationState& state, std::size_t drive,
                                int camera, const TimeInterval& window, const IntensityMap& map,
                                std::size_t count) {
  const CameraCalibration& calibration = state.cameras[camera];
  const SplitSpline& trajectory = state.drives[drive].trajectory;
  std::vector<Photo> photos;
  std::vector<ViewCandidate> candidates;
  for (const Keyframe& keyframe : tracks.keyframes) {
    if (keyframe.camera != camera) continue;
    const double first = calibration.sensor.OnImuClock(keyframe.time, trajectory.Middle());
    const double last = first + calibration.readout;
    if (!window.Contains(first) || !trajectory.Contains(first) || !trajectory.Contains(last)) {
      continue;
    }
    Photo photo;
    photo.drive = drive;
    photo.camera = camera;
    photo.image = keyframe.image;
    photo.time = keyframe.time;
    photo.pose = PoseOnTrajectory(trajectory, calibration.sensor, keyframe.time, calibration.readout,
                                  calibration.intrinsics.height);
    candidates.push_back({photo.pose, 1.0});
    photos.push_back(std::move(photo));
  }
  ViewSelectionOptions options;
  options.count = count;
  std::vector<Photo> chosen;
  for (const std::size_t i : SelectViews(map, calibration.intrinsics, candidates, options)) {
    chosen.push_back(photos[i]);
  }
  return chosen;
}

// How wrong a camera may be against the map: three sigmas of what is claimed. Where the map shows so little
// that it is matched at a coarser level, claims may be wrong by a pixel of that level.
CameraUncertainty SearchUncertainty(const PoseSigma& sigma, int level) {
  // from: guard against claims that leave nothing to search; a pixel is searched in any case.
  constexpr double kLeastRotation = 0.03 * M_PI / 180.0, kLeastTranslation = 3e-3;
  CameraUncertainty out = UncertaintyOf(std::max(kLeastRotation, 3.0 * sigma.rotation.maxCoeff()),
                                        std::max(kLeastTranslation, 3.0 * sigma.translation.maxCoeff()));
  if (level > 0) out.displacement = 1 << level;
  return out;
}

// How photos are matched, and at which resolution.
struct Matching {
  const ViewMatcher& matcher;
  int level = 0;
};

void Match(const CameraRecording& recording, const CameraCalibration& camera, const IntensityMap& map,
           const ViewRenderer& renderer, const PoseSigma& sigma, const Matching& matching, Photo* photo) {
  const cv::Mat gray = ToGray(recording.images->Load(photo->image));
  const RenderedView view = renderer.Render(photo->pose);
  photo->nid = ViewNid(view.intensity, gray, recording.mask, {});
  photo->matches = matching.matcher.Match({view, camera.intrinsics, photo->pose, gray, recording.mask},
                                          SearchUncertainty(sigma, matching.level), matching.level);
  photo->origins.clear();
  for (const MapMatch& match : photo->matches) photo->origins.push_back(map.origins[match.map_point]);
}

// The photos of those cameras for which the level before gave too few matches.
std::vector<Photo*> ToMatchAgain(std::vector<Photo>& photos, std::size_t first, std::size_t cameras) {
  std::vector<std::size_t> counts(cameras, 0), matches(cameras, 0);
  for (std::size_t i = first; i < photos.size(); ++i) {
    ++counts[photos[i].camera];
    matches[photos[i].camera] += photos[i].matches.size();
  }
  std::vector<Photo*> again;
  for (std::size_t i = first; i < photos.size(); ++i) {
    const int c = photos[i].camera;
    if (matches[c] < kFewestInPhoto * counts[c]) again.push_back(&photos[i]);
  }
  return again;
}

// Keeps the matches that agree with one pose of the camera on the vehicle, with sigmas as large as their
// scatter says. Share of those that do.
double KeepAgreeing(const CalibrationState& state, int camera, const MapMatchingOptions& map_options,
                    const std::vector<Photo*>& photos) {
  const double scale = map_options.noise.empty() ? 1.0 : map_options.noise[camera].scale;
  const CameraCalibration& calibration = state.cameras[camera];
  std::vector<PointCorrespondence> correspondences;
  for (const Photo* photo : photos) {
    const SplitSpline& trajectory = state.drives[photo->drive].trajectory;
    for (const MapMatch& match : photo->matches) {
      const double t = calibration.sensor.OnImuClock(photo->time, trajectory.Middle()) +
                       match.pixel.y() / calibration.intrinsics.height * calibration.readout;
      const double inside = std::clamp(t, trajectory.Start(), trajectory.End());
      correspondences.push_back(
          {trajectory.Pose(inside).Inverse() * match.point, match.pixel, match.covariance});
    }
  }
  PnpOptions options;
  options.fewest_inliers = map_options.fewest_matches;
  const RigidTransform guess = calibration.sensor.T_imu_sensor.Inverse();
  const auto pose = EstimatePose(correspondences, calibration.intrinsics, options, &guess);
  std::size_t k = 0;
  for (Photo* photo : photos) {
    std::vector<MapMatch> matches;
    std::vector<PointOrigin> origins;
    for (std::size_t i = 0; i < photo->matches.size(); ++i, ++k) {
      if (!pose || !pose->inlier[k]) continue;
      MapMatch match = photo->matches[i];
      match.covariance += options.model_sigma * options.model_sigma * Eigen::Matrix2d::Identity();
      match.covariance *= scale * scale * std::max(1.0, pose->chi2);
      matches.push_back(match);
      origins.push_back(photo->origins[i]);
    }
    photo->matches = std::move(matches);
    photo->origins = std::move(origins);
  }
  return pose ? static_cast<double>(pose->inliers) / static_cast<double>(correspondences.size()) : 0.0;
}

// Inverse of a square root of a covariance: whitens.
Eigen::Matrix2f Whitening(const Eigen::Matrix2d& covariance) {
  const Eigen::Matrix2d L = covariance.llt().matrixL();
  return Eigen::Matrix2d(L.inverse()).cast<float>();
}

void AddPoints(const Photo& photo, const CalibrationState& state, const MapMatchingOptions& options,
               LandmarkSet* set) {
  const SplitSpline& trajectory = state.drives[photo.drive].trajectory;
  const double middle = trajectory.Middle();
  const double camera_time = std::clamp(state.cameras[photo.camera].sensor.OnImuClock(photo.time, middle),
                                        trajectory.Start(), trajectory.End());
  const Eigen::Vector3d eye =
      (trajectory.Pose(camera_time) * state.cameras[photo.camera].sensor.T_imu_sensor).translation;
  for (std::size_t i = 0; i < photo.matches.size(); ++i) {
    const MapMatch& match = photo.matches[i];
    const PointOrigin& origin = photo.origins[i];
    const SensorCalibration& lidar = state.lidars[origin.lidar];
    const double t = lidar.OnImuClock(origin.time, middle);
    if (!trajectory.Contains(t)) continue;
    LidarPointObservation lidar_point;
    lidar_point.lidar = origin.lidar;
    lidar_point.time = origin.time;
    lidar_point.position = (trajectory.Pose(t) * lidar.T_imu_sensor).Inverse() * match.point;
    lidar_point.sigma_along = static_cast<float>(options.sigma_along);
    lidar_point.sigma_across = static_cast<float>(options.sigma_across);
    LandmarkObservation observation{photo.camera, 1.0f, photo.time, match.pixel, Whitening(match.covariance)};
    set->points.push_back({match.point, eye});
    set->lidar_points.push_back(lidar_point);
    set->observations.push_back(observation);
    set->begin.push_back(set->observations.size());
  }
}

}  // namespace

MapMatches MatchCamerasToMap(const Dataset& dataset, const CalibrationState& state,
                             const MatchedCameras& matched, const MapMatchingOptions& options,
                             const Monitor& monitor) {
  const std::size_t cameras = state.cameras.size();
  const std::unique_ptr<const ViewMatcher> matcher =
      options.features != nullptr ? MakeFeatureViewMatcher(*options.features) : MakeStructureViewMatcher();
  std::vector<std::pair<std::size_t, TimeInterval>> windows;
  for (std::size_t d = 0; d < dataset.drives.size(); ++d) {
    for (const TimeInterval& window : WindowsOf(state.drives[d].trajectory, options.window)) {
      windows.emplace_back(d, window);
    }
  }
  const std::size_t views = std::max<std::size_t>(2, (options.views + windows.size() - 1) / windows.size());
  std::vector<Photo> photos;
  for (std::size_t w = 0; w < windows.size(); ++w) {
    monitor.cancellation.ThrowIfCancelled();
    const auto& [d, window] = windows[w];
    const IntensityMap map = BuildIntensityMap(
        CollectReturns(dataset.drives[d], state.drives[d].trajectory, state.lidars, options.map_points,
                       window, CorrectionOfRings(state), matched.rejected_lidars));
    if (map.points.empty()) continue;
    std::vector<std::unique_ptr<const ViewRenderer>> renderers(cameras);
    std::vector<std::vector<Photo>> of_cameras(cameras);
    ParallelFor(cameras, [&, d = d, window = window](std::size_t c) {
      if (!matched.found[c]) return;
      renderers[c] = std::make_unique<const ViewRenderer>(map, state.cameras[c].intrinsics, RenderOptions());
      of_cameras[c] = ChoosePhotos(matched.tracks[d], state, d, static_cast<int>(c), window, map, views);
    });
    const std::size_t first = photos.size();
    for (std::vector<Photo>& of_camera : of_cameras) {
      std::move(of_camera.begin(), of_camera.end(), std::back_inserter(photos));
    }
    for (int level = 0; level <= kCoarsestLevel; ++level) {
      const std::vector<Photo*> unmatched = ToMatchAgain(photos, first, cameras);
      ParallelFor(unmatched.size(), [&, d = d](std::size_t i) {
        if (monitor.cancellation.IsCancelled()) return;
        Photo& photo = *unmatched[i];
        Match(dataset.drives[d].cameras[photo.camera], state.cameras[photo.camera], map,
              *renderers[photo.camera], matched.sigmas[photo.camera], {*matcher, level}, &photo);
      });
    }
    monitor.progress((w + 1.0) / static_cast<double>(windows.size()));
  }
  monitor.cancellation.ThrowIfCancelled();

  MapMatches result;
  result.counts.assign(cameras, 0);
  result.inlier_share.assign(cameras, 0.0);
  result.nid.assign(cameras, 1.0);
  for (std::size_t c = 0; c < cameras; ++c) {
    std::vector<Photo*> own;
    for (Photo& photo : photos) {
      if (photo.camera == static_cast<int>(c)) own.push_back(&photo);
    }
    if (own.empty()) continue;
    result.inlier_share[c] = KeepAgreeing(state, static_cast<int>(c), options, own);
    double nid = 0.0;
    for (const Photo* photo : own) {
      nid += photo->nid / static_cast<double>(own.size());
      result.counts[c] += photo->matches.size();
    }
    result.nid[c] = nid;
  }
  result.landmarks.resize(dataset.drives.size());
  for (LandmarkSet& set : result.landmarks) set.begin.push_back(0);
  for (const Photo& photo : photos) AddPoints(photo, state, options, &result.landmarks[photo.drive]);
  return result;
}

void Append(const LandmarkSet& more, LandmarkSet* landmarks) {
  if (landmarks->begin.empty()) landmarks->begin.push_back(0);
  landmarks->lidar_points.resize(landmarks->points.size());
  const std::size_t before = landmarks->observations.size();
  landmarks->points.insert(landmarks->points.end(), more.points.begin(), more.points.end());
  landmarks->observations.insert(landmarks->observations.end(), more.observations.begin(),
                                 more.observations.end());
  landmarks->lidar_points.insert(landmarks->lidar_points.end(), more.lidar_points.begin(),
                                 more.lidar_points.end());
  landmarks->lidar_points.resize(landmarks->points.size());
  for (std::size_t p = 1; p < more.begin.size(); ++p) landmarks->begin.push_back(before + more.begin[p]);
}

}  // namespace mlic
