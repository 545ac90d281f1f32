#include "mlic_core/evaluation/map_reprojection.h"

#include <algorithm>
#include <cstdio>
#include <set>

#include "mlic_core/association/held_out_matches.h"
#include "mlic_core/association/map_matches.h"
#include "mlic_core/evaluation/fresh_matches.h"
#include "mlic_core/evaluation/truth_comparison.h"
#include "mlic_core/initialization/pose_fit.h"

namespace mlic {
namespace {

constexpr std::size_t kFewestMatches = 30;  // from: definition of the figure of merit
// The search takes three of them. from: definition of the figure of merit
constexpr double kSearchRotation = 0.1 * M_PI / 180.0, kSearchTranslation = 0.01;  // rad, m
constexpr double kSpacing = 0.01;  // s, of the trajectory's knots; from: structural, that of trajectory.tum

// The calibration of these sensors in these rows, on the trajectory; those that it lacks stay at the
// identity.
CalibrationState StateOf(const std::vector<std::string>& lidars, const std::vector<std::string>& cameras,
                         const CalibrationResult& calibration, const std::vector<StampedPose>& trajectory,
                         TimeNs epoch) {
  CalibrationState state;
  state.lidars.resize(lidars.size());
  state.rings.resize(lidars.size());
  state.ranges.resize(lidars.size());
  state.cameras.resize(cameras.size());
  for (std::size_t l = 0; l < lidars.size(); ++l) {
    const SensorResult* lidar = FindSensor(calibration, lidars[l]);
    if (lidar == nullptr) continue;
    state.lidars[l] = lidar->calibration;
    const PointCorrections& corrections = lidar->corrections;
    state.ranges[l] = {corrections.range_offset, corrections.range_slope, corrections.range_walk,
                       corrections.reference_intensity};
    for (const PointCorrections::Ring& ring : corrections.rings) {
      RingCorrections& rings = state.rings[l];
      rings.resize(std::max(rings.size(), static_cast<std::size_t>(ring.ring) + 1));
      rings[static_cast<std::size_t>(ring.ring)] = {static_cast<float>(ring.range),
                                                    static_cast<float>(ring.elevation)};
    }
  }
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    const SensorResult* camera = FindCamera(calibration, cameras[c]);
    if (camera == nullptr) continue;
    state.cameras[c].sensor = camera->calibration;
    state.cameras[c].intrinsics = *camera->intrinsics;
    state.cameras[c].rolling_shutter = camera->rolling_shutter_readout.has_value();
    state.cameras[c].readout = camera->rolling_shutter_readout.value_or(0.0);
  }
  std::vector<TimedPose> poses;
  for (const StampedPose& pose : trajectory) poses.push_back({SecondsSince(epoch, pose.time), pose.pose});
  state.drives.emplace_back();
  state.drives[0].trajectory = SplineThrough(poses, KnotSpacing{kSpacing, kSpacing});
  return state;
}

// All photos of the cameras that the calibration has but the keyframes.
TrackSet FreshPhotos(const std::vector<std::string>& cameras, const Drive& drive,
                     const std::vector<CameraKeyframes>& keyframes) {
  TrackSet photos;
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    std::set<TimeNs> used;
    for (const CameraKeyframes& of_camera : keyframes) {
      if (of_camera.camera == cameras[c]) used.insert(of_camera.stamps.begin(), of_camera.stamps.end());
    }
    if (drive.cameras[c].images == nullptr) continue;
    const ImageSource& images = *drive.cameras[c].images;
    for (std::size_t i = 0; i < images.Count(); ++i) {
      if (used.count(TimeFrom(drive.epoch, images.Time(i))) > 0) continue;
      photos.keyframes.push_back({static_cast<int>(c), i, images.Time(i)});
    }
  }
  return photos;
}

// Those of one LiDAR, or of all where lidar is negative, in one camera.
LandmarkSet Between(const LandmarkSet& matches, int lidar, int camera) {
  LandmarkSet chosen;
  chosen.begin.push_back(0);
  for (std::size_t p = 0; p < matches.points.size(); ++p) {
    if (matches.observations[matches.begin[p]].camera != camera) continue;
    if (lidar < 0 || matches.lidar_points[p].lidar == lidar) AddMatch(matches, p, &chosen);
  }
  return chosen;
}

bool IsOf(const ReprojectionStatistics& a, const ReprojectionStatistics& b) {
  return a.lidar == b.lidar && a.camera == b.camera;
}

}  // namespace

MapSightings FindMapSightings(const Rig& rig, const Dataset& dataset, const CalibrationResult& calibration,
                              const std::vector<StampedPose>& trajectory,
                              const std::vector<CameraKeyframes>& keyframes,
                              const CancellationToken& cancellation) {
  MapSightings sightings;
  std::vector<bool> rejected, found;
  for (const LidarConfig& lidar : rig.lidars) {
    sightings.lidars.push_back(lidar.name);
    rejected.push_back(FindSensor(calibration, lidar.name) == nullptr);
  }
  for (const CameraConfig& camera : rig.cameras) {
    sightings.cameras.push_back(camera.name);
    found.push_back(FindCamera(calibration, camera.name) != nullptr);
  }
  const Drive& drive = dataset.drives.front();
  const std::vector<TrackSet> photos{FreshPhotos(sightings.cameras, drive, keyframes)};
  PoseSigma search;
  search.rotation.setConstant(kSearchRotation);
  search.translation.setConstant(kSearchTranslation);
  const std::vector<PoseSigma> sigmas(found.size(), search);
  const CalibrationState state =
      StateOf(sightings.lidars, sightings.cameras, calibration, trajectory, drive.epoch);
  MapMatches matches = MatchCamerasToMap(dataset, state, {photos, sigmas, found, rejected},
                                         MapMatchingOptions(), {cancellation});
  sightings.matches = std::move(matches.landmarks.front());
  return sightings;
}

std::vector<ReprojectionStatistics> MeasureReprojection(const MapSightings& sightings,
                                                        const CalibrationResult& calibration,
                                                        const std::vector<StampedPose>& trajectory,
                                                        TimeNs epoch) {
  std::vector<ReprojectionStatistics> errors;
  if (sightings.matches.points.empty()) return errors;
  const CalibrationState state = StateOf(sightings.lidars, sightings.cameras, calibration, trajectory, epoch);
  const auto has = [&](const std::string& name) { return FindSensor(calibration, name) != nullptr; };
  const int lidars = static_cast<int>(sightings.lidars.size());
  for (std::size_t c = 0; c < sightings.cameras.size(); ++c) {
    const bool all = std::all_of(sightings.lidars.begin(), sightings.lidars.end(), has);
    if (!has(sightings.cameras[c])) continue;
    for (int l = all ? -1 : 0; l < lidars; ++l) {
      const std::string lidar = l < 0 ? "" : sightings.lidars[static_cast<std::size_t>(l)];
      if (l >= 0 && !has(lidar)) continue;
      const HeldOutMatches found =
          EvaluateHeldOutMatches({Between(sightings.matches, l, static_cast<int>(c))}, state)[c];
      if (found.count < kFewestMatches) continue;
      errors.push_back({lidar, sightings.cameras[c], found.count, found.median, found.rms});
    }
  }
  return errors;
}

std::string TableOf(const std::vector<ReprojectionColumn>& columns) {
  if (columns.empty() || columns.front().errors.empty()) return "no camera shows the map\n";
  std::string table;
  char text[200];
  for (const ReprojectionStatistics& row : columns.front().errors) {
    std::snprintf(text, sizeof(text), " (%zu matches):", row.matches);
    table += row.camera + " / " + (row.lidar.empty() ? "all LiDARs" : row.lidar) + text;
    const char* separator = " ";
    for (const ReprojectionColumn& column : columns) {
      const auto error = std::find_if(column.errors.begin(), column.errors.end(),
                                      [&](const ReprojectionStatistics& e) { return IsOf(e, row); });
      if (error == column.errors.end()) continue;
      std::snprintf(text, sizeof(text), " median %.2f px, rms %.2f px", error->median, error->rms);
      table += separator + column.name + text;
      separator = "; ";
    }
    table += "\n";
  }
  return table;
}

std::string CsvOf(const std::vector<ReprojectionColumn>& columns) {
  std::string csv = "calibration,lidar,camera,matches,median_px,rms_px\n";
  char text[160];
  for (const ReprojectionColumn& column : columns) {
    for (const ReprojectionStatistics& error : column.errors) {
      std::snprintf(text, sizeof(text), ",%zu,%.6f,%.6f\n", error.matches, error.median, error.rms);
      csv += column.name + "," + (error.lidar.empty() ? "all" : error.lidar) + "," + error.camera + text;
    }
  }
  return csv;
}

}  // namespace mlic
