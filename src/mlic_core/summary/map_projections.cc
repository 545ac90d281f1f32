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

// The time of the camera's photo with most points of the map.
std::optional<double> BestPhoto(const LandmarkSet& landmarks, std::size_t camera) {
  std::map<double, int> counts;
  for (std::size_t p = 0; p < landmarks.points.size(); ++p) {
    if (!landmarks.IsOnMap(p)) continue;
    const LandmarkObservation& o = landmarks.observations[landmarks.begin[p]];
    if (o.camera == static_cast<int>(camera)) ++counts[o.time];
  }
  std::optional<double> best;
  int most = 0;
  for (const auto& [time, count] : counts) {
    if (count > most) best = time, most = count;
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

void DrawFound(const LidarView& view, std::size_t camera, double stamp, const CameraCalibration& before,
               const LandmarkSet& landmarks, CameraProjection* out) {
  const SplitSpline& trajectory = view.state.drives[0].trajectory;
  const CameraCalibration& after = view.state.cameras[camera];
  const double time = after.sensor.OnImuClock(stamp, trajectory.Middle());
  const std::vector<MapReturn> returns = view.Around(time, kOverlaySeconds, kMostPoints);
  out->before = Overlay(returns, trajectory, before, stamp);
  out->after = Overlay(returns, trajectory, after, stamp);
  const IntensityMap map = BuildIntensityMap(view.Around(time, kMapSeconds, kMapPoints));
  out->rendering =
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
      out->matches.push_back({o.pixel.cast<float>(), from.cast<float>(), to.cast<float>()});
    }
  }
}

// What the LiDARs saw about the photo, with the poses of the rig file.
std::vector<ProjectedPoint> DrawGuess(const LidarView& guess, std::size_t camera, double stamp) {
  const SplitSpline& trajectory = guess.state.drives[0].trajectory;
  const CameraCalibration& calibration = guess.state.cameras[camera];
  const double time = calibration.sensor.OnImuClock(stamp, trajectory.Middle());
  return Overlay(guess.Around(time, kOverlaySeconds, kMostPoints), trajectory, calibration, stamp);
}

}  // namespace

std::optional<CameraProjection> ProjectOnPhoto(const Rig& rig, const Dataset& dataset,
                                               const Adjustment& adjustment, std::size_t camera) {
  const bool found = adjustment.cameras.found[camera];
  const Drive& drive = dataset.drives[0];
  const std::shared_ptr<const ImageSource>& images = drive.cameras[camera].images;
  if (rig.lidars.empty() || images->Count() == 0 || (!found && !rig.cameras[camera].guess))
    return std::nullopt;
  const CalibrationState& state = adjustment.state;
  const LandmarkSet& landmarks = adjustment.problem.drives[0].landmarks;
  const CameraCalibration& calibration = state.cameras[camera];
  const double middle = state.drives[0].trajectory.Middle();
  const std::optional<double> best = BestPhoto(landmarks, camera);
  CameraProjection projection;
  projection.image = NearestImage(*images, best.value_or(calibration.sensor.OnOwnClock(middle, middle)));
  const double stamp = best.value_or(images->Time(projection.image));
  if (found) {
    const std::vector<CameraCalibration>& before = adjustment.map.cameras_before;
    DrawFound({drive, state, adjustment.rejected_lidars}, camera, stamp,
              before.empty() ? calibration : before[camera], landmarks, &projection);
  }
  projection.found = found;
  projection.camera = rig.cameras[camera].name;
  projection.images = images;
  if (HasGuesses(rig)) {
    const CalibrationState guess = AtGuesses(rig, state);
    projection.guess = DrawGuess({drive, guess, adjustment.rejected_lidars}, camera, stamp);
  }
  return projection;
}

}  // namespace mlic
