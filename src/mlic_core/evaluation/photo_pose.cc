#include "mlic_core/evaluation/photo_pose.h"

#include <algorithm>
#include <cmath>

#include "mlic_core/evaluation/fresh_matches.h"
#include "mlic_core/evaluation/pose_interpolation.h"
#include "mlic_core/sensors/camera_model.h"

namespace mlic {
namespace {

// Of a photo's width, within which its weight falls at its border; from: structural, how pictures look.
constexpr double kFeather = 0.15;

}  // namespace

std::optional<PhotoPose> PhotoPose::Of(const SensorResult& camera, const std::vector<StampedPose>& trajectory,
                                       TimeNs stamp) {
  PhotoPose photo;
  photo.camera_ = &camera;
  photo.rolling_ = camera.rolling_shutter_readout.value_or(0.0) != 0.0;
  if (!PoseOfRow(camera, trajectory, stamp, 0.0, &photo.first_) ||
      !PoseOfRow(camera, trajectory, stamp, camera.intrinsics->height, &photo.last_)) {
    return std::nullopt;
  }
  return photo;
}

bool PhotoPose::Project(const Eigen::Vector3d& p_in_map, double row, Eigen::Vector2d* pixel,
                        double* distance) const {
  RigidTransform T_map_camera = first_;
  if (rolling_) {
    const double share = row / camera_->intrinsics->height;
    T_map_camera.rotation = first_.rotation.slerp(share, last_.rotation);
    T_map_camera.translation = (1.0 - share) * first_.translation + share * last_.translation;
  }
  const Eigen::Vector3d p_in_camera = T_map_camera.Inverse() * p_in_map;
  *distance = p_in_camera.norm();
  return mlic::Project(*camera_->intrinsics, p_in_camera, pixel);
}

bool PhotoPose::See(const Eigen::Vector3d& p_in_map, Eigen::Vector2d* pixel, double* distance) const {
  const CameraIntrinsics& intrinsics = *camera_->intrinsics;
  if (!Project(p_in_map, 0.5 * intrinsics.height, pixel, distance)) return false;
  // Twice is enough: a row's time changes the pixel by far less than a row.
  for (int i = 0; rolling_ && i < 2; ++i) {
    if (!Project(p_in_map, pixel->y(), pixel, distance)) return false;
  }
  return pixel->x() >= 0.0 && pixel->y() >= 0.0 && pixel->x() <= intrinsics.width - 1 &&
         pixel->y() <= intrinsics.height - 1;
}

double PhotoPose::WeightOf(const Eigen::Vector2d& pixel, double distance) const {
  const CameraIntrinsics& intrinsics = *camera_->intrinsics;
  const double inside = std::min(std::min(pixel.x(), intrinsics.width - 1 - pixel.x()),
                                 std::min(pixel.y(), intrinsics.height - 1 - pixel.y()));
  const double share = std::min(1.0, inside / (kFeather * intrinsics.width));
  return share * share / (distance * distance);
}

std::optional<std::size_t> NearestPhoto(const CameraRecording& recording, const SensorResult& camera,
                                        const Drive& drive, const std::vector<StampedPose>& trajectory,
                                        TimeNs time) {
  if (recording.images == nullptr || trajectory.empty()) return std::nullopt;
  const double middle = SecondsSince(drive.epoch, MiddleOf(trajectory));
  const double wanted = SecondsSince(drive.epoch, time);
  std::optional<std::size_t> nearest;
  double distance = 0.0;
  for (std::size_t i = 0; i < recording.images->Count(); ++i) {
    const double apart = std::abs(camera.calibration.OnImuClock(recording.images->Time(i), middle) - wanted);
    if (!nearest || apart < distance) {
      nearest = i;
      distance = apart;
    }
  }
  return nearest;
}

}  // namespace mlic
