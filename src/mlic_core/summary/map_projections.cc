#include "mlic_core/summary/map_projections.h"

#include <algorithm>
#include <map>
#include <optional>

#include "mlic_core/association/ring_corrections.h"
#include "mlic_core/crossmodal/renderer.h"

namespace mlic {
namespace {

// Constants of this file, from: structural, how a picture looks.

constexpr double kMapSeconds = 3.0;      // either side of the photo, for the rendering
constexpr double kOverlaySeconds = 0.1;  // either side, for the points drawn on the photo
constexpr std::size_t kMapPoints = 1000000;
constexpr std::size_t kMostPoints = 60000;

// Times of the photos with most points of the map, of each camera.
std::vector<std::optional<double>> BestPhotos(const LandmarkSet& landmarks, std::size_t cameras) {
  std::vector<std::map<double, int>> counts(cameras);
  for (std::size_t p = 0; p < landmarks.points.size(); ++p) {
    if (!landmarks.IsOnMap(p)) continue;
    const LandmarkObservation& o = landmarks.observations[landmarks.begin[p]];
    ++counts[o.camera][o.time];
  }
  std::vector<std::optional<double>> best(cameras);
  for (std::size_t c = 0; c < cameras; ++c) {
    int most = 0;
    for (const auto& [time, count] : counts[c]) {
      if (count > most) best[c] = time, most = count;
    }
  }
  return best;
}

// Where a camera on the trajectory sees a point of the map in the photo of this stamp, its row exposed when
// `row` is.
bool See(const SplitSpline& trajectory, const CameraCalibration& camera, double stamp, double row,
         const Eigen::Vector3d& point, Eigen::Vector2d* pixel, double* depth) {
  const double t = std::clamp(
      camera.sensor.OnImuClock(stamp, trajectory.Middle()) + row / camera.intrinsics.height * camera.readout,
      trajectory.Start(), trajectory.End());
  const Eigen::Vector3d p = (trajectory.Pose(t) * camera.sensor.T_imu_sensor).Inverse() * point;
  *depth = p.norm();
  return Project(camera.intrinsics, p, pixel) && pixel->x() > -0.5 && pixel->y() > -0.5 &&
         pixel->x() < camera.intrinsics.width - 0.5 && pixel->y() < camera.intrinsics.height - 0.5;
}

std::vector<ProjectedPoint> Overlay(const std::vector<MapReturn>& returns, const SplitSpline& trajectory,
                                    const CameraCalibration& camera, double stamp) {
  const double middle = 0.5 * camera.intrinsics.height;
  std::vector<ProjectedPoint> points;
  for (const MapReturn& r : returns) {
    Eigen::Vector2d pixel;
    double depth;
    if (!See(trajectory, camera, stamp, middle, r.position.cast<double>(), &pixel, &depth)) continue;
    points.push_back({pixel.cast<float>(), static_cast<float>(depth), r.intensity});
  }
  return points;
}

// The first drive and its LiDARs.
struct LidarView {
  const Drive& drive;
  const CalibrationState& state;
  const std::vector<bool>& rejected;

  // What they see so many seconds about the time (IMU clock).
  std::vector<MapReturn> Around(double time, double seconds, std::size_t most) const {
    return CollectReturns(drive, state.drives[0].trajectory, state.lidars, most,
                          TimeInterval{time - seconds, time + seconds}, CorrectionOfRings(state), rejected);
  }
};

// The sensors where the rig file has them, those without a guess where they were found.
CalibrationState AtGuesses(const Rig& rig, CalibrationState state) {
  for (std::size_t l = 0; l < state.lidars.size(); ++l) {
    if (rig.lidars[l].guess) state.lidars[l].T_imu_sensor = rig.lidars[l].guess->T_imu_sensor;
  }
  for (std::size_t c = 0; c < state.cameras.size(); ++c) {
    if (rig.cameras[c].guess) state.cameras[c].sensor.T_imu_sensor = rig.cameras[c].guess->T_imu_sensor;
  }
  return state;
}

bool HasGuesses(const Rig& rig) {
  const auto guessed = [](const auto& sensor) { return sensor.guess.has_value(); };
  return std::any_of(rig.lidars.begin(), rig.lidars.end(), guessed) ||
         std::any_of(rig.cameras.begin(), rig.cameras.end(), guessed);
}

CameraProjection ProjectOnPhoto(const std::string& name, const LidarView& view, std::size_t camera,
                                double stamp, const CameraCalibration& before, const LandmarkSet& landmarks) {
  const SplitSpline& trajectory = view.state.drives[0].trajectory;
  const CameraCalibration& after = view.state.cameras[camera];
  const double time = after.sensor.OnImuClock(stamp, trajectory.Middle());
  CameraProjection out;
  out.camera = name;
  out.images = view.drive.cameras[camera].images;
  out.image = NearestImage(*out.images, stamp);
  const std::vector<MapReturn> returns = view.Around(time, kOverlaySeconds, kMostPoints);
  out.before = Overlay(returns, trajectory, before, stamp);
  out.after = Overlay(returns, trajectory, after, stamp);
  const IntensityMap map = BuildIntensityMap(view.Around(time, kMapSeconds, kMapPoints));
  out.rendering =
      ViewRenderer(map, after.intrinsics, RenderOptions())
          .Render(PoseOnTrajectory(trajectory, after.sensor, stamp, after.readout, after.intrinsics.height))
          .intensity;
  for (std::size_t p = 0; p < landmarks.points.size(); ++p) {
    if (!landmarks.IsOnMap(p)) continue;
    const LandmarkObservation& o = landmarks.observations[landmarks.begin[p]];
    if (o.camera != static_cast<int>(camera) || o.time != stamp) continue;
    Eigen::Vector2d from, to;
    double depth;
    const Eigen::Vector3d& point = landmarks.points[p].position;
    if (See(trajectory, before, stamp, o.pixel.y(), point, &from, &depth) &&
        See(trajectory, after, stamp, o.pixel.y(), point, &to, &depth)) {
      out.matches.push_back({o.pixel.cast<float>(), from.cast<float>(), to.cast<float>()});
    }
  }
  return out;
}

}  // namespace

std::vector<CameraProjection> ProjectOnPhotos(const Rig& rig, const Dataset& dataset,
                                              const std::vector<CameraCalibration>& before,
                                              const CalibrationState& state, const LandmarkSet& landmarks,
                                              const std::vector<bool>& rejected_lidars) {
  const std::vector<std::optional<double>> best = BestPhotos(landmarks, rig.cameras.size());
  const bool guessed = HasGuesses(rig);
  const Drive& drive = dataset.drives[0];
  const CalibrationState guess = AtGuesses(rig, state);
  std::vector<CameraProjection> projections;
  for (std::size_t c = 0; c < best.size(); ++c) {
    if (!best[c]) continue;
    projections.push_back(ProjectOnPhoto(rig.cameras[c].name, {drive, state, rejected_lidars}, c, *best[c],
                                         before[c], landmarks));
    if (!guessed) continue;
    const SplitSpline& trajectory = state.drives[0].trajectory;
    const double time = state.cameras[c].sensor.OnImuClock(*best[c], trajectory.Middle());
    const LidarView at_guess{drive, guess, rejected_lidars};
    projections.back().guess =
        Overlay(at_guess.Around(time, kOverlaySeconds, kMostPoints), trajectory, guess.cameras[c], *best[c]);
  }
  return projections;
}

}  // namespace mlic
