#include "mlic_core/initialization/camera_imu/observations.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "mlic_core/common/parallel.h"

namespace mlic {
namespace {

constexpr double kLeastParallax = 0.002;  // rad; what turns less has no say but much rounding
constexpr double kTypicalSpeed = 1.0;     // m/s; a common factor of all first distances only

bool MakeSight(const KnownRotations& known, std::size_t drive, const Keyframe& keyframe,
               const TrackObservation& seen, Sight* sight) {
  const CameraCalibration& camera = known.cameras[keyframe.camera];
  const Eigen::Vector2d pixel = seen.pixel.cast<double>();
  const double row_time = pixel.y() / camera.intrinsics.height * camera.readout;
  sight->camera = keyframe.camera;
  sight->time = keyframe.time + camera.sensor.time_offset + row_time;
  const GyroIntegration& gyro = known.gyro[drive];
  if (sight->time < gyro.Start() || sight->time > gyro.End()) return false;
  Eigen::Vector3d bearing;
  if (!Unproject(camera.intrinsics, pixel, &bearing)) return false;
  const Eigen::Quaterniond rotation = gyro.RotationTo(sight->time);
  sight->rotation = rotation.toRotationMatrix();
  sight->direction = rotation * (camera.sensor.T_imu_sensor.rotation * bearing);
  const double sigma = std::max<double>(known.least_sigma, seen.sigma);
  sight->sigma = sigma / camera.intrinsics.parameters[0];
  return true;
}

// First distances of the part [begin, end) of sights in order of time; nothing without parallax.
void AddPart(std::size_t drive, const std::vector<Sight>& sights, std::size_t begin, std::size_t end,
             std::vector<SightedPoint>* points) {
  if (end - begin < 2) return;
  double parallax = 0.0, elapsed = 0.0;
  for (std::size_t i = begin; i < end; ++i) {
    const Sight &a = sights[begin], &b = sights[i];
    const double angle = std::atan2(a.direction.cross(b.direction).norm(), a.direction.dot(b.direction));
    if (angle <= parallax) continue;
    parallax = angle;
    elapsed = b.time - a.time;
  }
  if (parallax < kLeastParallax) return;
  SightedPoint point{drive, {sights.begin() + begin, sights.begin() + end}};
  const double distance = kTypicalSpeed * std::max(0.1, elapsed) / std::max(0.01, parallax);
  for (Sight& sight : point.sights) sight.distance = std::clamp(distance, 0.2, 100.0);
  points->push_back(std::move(point));
}

}  // namespace

std::vector<SightedPoint> CollectSights(const KnownRotations& known, double longest) {
  std::vector<SightedPoint> points;
  for (std::size_t d = 0; d < known.tracks->size(); ++d) {
    const TrackSet& set = (*known.tracks)[d];
    std::vector<std::vector<SightedPoint>> of_track(set.tracks.size());
    ParallelFor(set.tracks.size(), [&](std::size_t t) {
      std::vector<Sight> sights;
      for (const TrackObservation& seen : set.tracks[t].observations) {
        const Keyframe& keyframe = set.keyframes[seen.keyframe];
        Sight sight;
        if (known.found[keyframe.camera] && MakeSight(known, d, keyframe, seen, &sight))
          sights.push_back(sight);
      }
      std::stable_sort(sights.begin(), sights.end(),
                       [](const Sight& a, const Sight& b) { return a.time < b.time; });
      for (std::size_t begin = 0, end = 0; begin < sights.size(); begin = end) {
        while (end < sights.size() && sights[end].time - sights[begin].time <= longest) ++end;
        AddPart(d, sights, begin, end, &of_track[t]);
      }
    });
    for (std::vector<SightedPoint>& parts : of_track) {
      points.insert(points.end(), parts.begin(), parts.end());
    }
  }
  return points;
}

}  // namespace mlic
