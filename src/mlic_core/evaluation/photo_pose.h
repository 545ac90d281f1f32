#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "mlic_core/result/result.h"
#include "mlic_core/sensors/measurements.h"

namespace mlic {

// One photo of a drive and where its camera was, for pictures that are put together from photos. Each row has
// its own time: poses between those of the first and the last row are interpolated.
class PhotoPose {
 public:
  // The photo of a camera whose row 0 has this stamp; none where the trajectory (T_map_imu) does not reach.
  // The camera, which has intrinsics, must outlive it.
  static std::optional<PhotoPose> Of(const SensorResult& camera, const std::vector<StampedPose>& trajectory,
                                     TimeNs stamp);

  // Where the photo shows a point of the map, px, and the point's distance, m; false where it does not.
  bool See(const Eigen::Vector3d& p_in_map, Eigen::Vector2d* pixel, double* distance) const;

  // How much the photo counts for a point that it shows there: near ones more, those near the border, which
  // lenses darken and blur, less; 0 at the border.
  double WeightOf(const Eigen::Vector2d& pixel, double distance) const;

  const CameraIntrinsics& intrinsics() const { return *camera_->intrinsics; }
  // Of the camera in the middle of the photo, m, map frame.
  Eigen::Vector3d Centre() const { return 0.5 * (first_.translation + last_.translation); }

 private:
  bool Project(const Eigen::Vector3d& p_in_map, double row, Eigen::Vector2d* pixel, double* distance) const;

  const SensorResult* camera_ = nullptr;
  RigidTransform first_, last_;  // T_map_camera of row 0 and of the row after the last
  bool rolling_ = false;
};

// The photo of a camera that is nearest to a time of the IMU's clock; none without photos.
std::optional<std::size_t> NearestPhoto(const CameraRecording& recording, const SensorResult& camera,
                                        const Drive& drive, const std::vector<StampedPose>& trajectory,
                                        TimeNs time);

}  // namespace mlic
