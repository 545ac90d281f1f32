#include "mlic_core/initialization/camera_imu/observations.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "mlic_core/common/parallel.h"

namespace mlic {
namespace {

constexpr double kLeastParallax = 0.002;  // rad; what turns less has no say but much rounding; from: guard
// from: structural, a common factor.
constexpr double kTypicalSpeed = 1.0;  // m/s; a common factor of all first distances only

bool MakeObservation(const KnownRotations& known, std::size_t drive, const Keyframe& keyframe,
                     const TrackObservation& seen, DirectionObservation* observation) {
  const CameraCalibration& camera = known.cameras[keyframe.camera];
  const Eigen::Vector2d pixel = seen.pixel.cast<double>();
  const double row_time = pixel.y() / camera.intrinsics.height * camera.readout;
  observation->camera = keyframe.camera;
  observation->time = keyframe.time + camera.sensor.time_offset + row_time;
  const GyroIntegration& gyro = known.gyro[drive];
  if (observation->time < gyro.Start() || observation->time > gyro.End()) return false;
  Eigen::Vector3d bearing;
  if (!Unproject(camera.intrinsics, pixel, &bearing)) return false;
  const Eigen::Quaterniond rotation = gyro.RotationTo(observation->time);
  observation->rotation = rotation.toRotationMatrix();
  observation->direction = rotation * (camera.sensor.T_imu_sensor.rotation * bearing);
  observation->ray = observation->direction;
  const double sigma = std::max<double>(known.least_sigma, seen.sigma);
  observation->sigma = sigma / camera.intrinsics.parameters[0];
  return true;
}

// First distances of the part [begin, end) of observations in order of time; nothing without parallax.
void AddPart(std::size_t drive, const std::vector<DirectionObservation>& observations, std::size_t begin,
             std::size_t end, std::vector<PointObservations>* points) {
  if (end - begin < 2) return;
  double parallax = 0.0, elapsed = 0.0;
  for (std::size_t i = begin; i < end; ++i) {
    const DirectionObservation &a = observations[begin], &b = observations[i];
    const double angle = std::atan2(a.direction.cross(b.direction).norm(), a.direction.dot(b.direction));
    if (angle <= parallax) continue;
    parallax = angle;
    elapsed = b.time - a.time;
  }
  if (parallax < kLeastParallax) return;
  PointObservations point{drive, {observations.begin() + begin, observations.begin() + end}};
  const double distance = kTypicalSpeed * std::max(0.1, elapsed) / std::max(0.01, parallax);
  for (DirectionObservation& observation : point.observations)
    observation.distance = std::clamp(distance, 0.2, 100.0);
  points->push_back(std::move(point));
}

}  // namespace

std::vector<PointObservations> CollectObservations(const KnownRotations& known, double longest) {
  std::vector<PointObservations> points;
  for (std::size_t d = 0; d < known.tracks->size(); ++d) {
    const TrackSet& set = (*known.tracks)[d];
    std::vector<std::vector<PointObservations>> of_track(set.tracks.size());
    ParallelFor(set.tracks.size(), [&](std::size_t t) {
      std::vector<DirectionObservation> observations;
      for (const TrackObservation& seen : set.tracks[t].observations) {
        const Keyframe& keyframe = set.keyframes[seen.keyframe];
        DirectionObservation observation;
        if (known.found[keyframe.camera] && MakeObservation(known, d, keyframe, seen, &observation))
          observations.push_back(observation);
      }
      std::stable_sort(
          observations.begin(), observations.end(),
          [](const DirectionObservation& a, const DirectionObservation& b) { return a.time < b.time; });
      for (std::size_t begin = 0, end = 0; begin < observations.size(); begin = end) {
        while (end < observations.size() && observations[end].time - observations[begin].time <= longest)
          ++end;
        AddPart(d, observations, begin, end, &of_track[t]);
      }
    });
    for (std::vector<PointObservations>& parts : of_track) {
      points.insert(points.end(), parts.begin(), parts.end());
    }
  }
  return points;
}

}  // namespace mlic
