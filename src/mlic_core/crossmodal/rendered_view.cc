#include "mlic_core/crossmodal/rendered_view.h"

#include <cmath>

namespace mlic {

ViewPose FixedPose(const RigidTransform& T_map_camera) {
  return {[T_map_camera](double) { return T_map_camera; }, false};
}

ViewPose PoseOnTrajectory(const SplitSpline& trajectory, const SensorCalibration& camera, double image_time,
                          double readout, int height) {
  const double start = camera.OnImuClock(image_time, trajectory.Middle());
  const SplitSpline* spline = &trajectory;
  if (readout == 0.0) return FixedPose(trajectory.Pose(start) * camera.T_imu_sensor);
  return {[=](double row) { return spline->Pose(start + row / height * readout) * camera.T_imu_sensor; },
          true};
}

bool SurfaceAt(const RenderedView& view, const CameraIntrinsics& intrinsics, const ViewPose& pose,
               const Eigen::Vector2d& pixel, Eigen::Vector3d* position) {
  const int column = static_cast<int>(std::floor(pixel.x())), row = static_cast<int>(std::floor(pixel.y()));
  const int nearest_column = static_cast<int>(std::lround(pixel.x())),
            nearest_row = static_cast<int>(std::lround(pixel.y()));
  if (nearest_column < 0 || nearest_row < 0 || nearest_column >= intrinsics.width ||
      nearest_row >= intrinsics.height || !view.IsSeen(nearest_column, nearest_row)) {
    return false;
  }
  const double nearest = view.depth.at<float>(nearest_row, nearest_column);
  const double a = pixel.x() - column, b = pixel.y() - row;
  double weights = 0.0, depths = 0.0;
  for (int j = 0; j < 2; ++j) {
    for (int i = 0; i < 2; ++i) {
      const int x = column + i, y = row + j;
      if (x < 0 || y < 0 || x >= intrinsics.width || y >= intrinsics.height || !view.IsSeen(x, y)) continue;
      const double depth = view.depth.at<float>(y, x);
      if (std::abs(depth - nearest) > 0.05 + 0.03 * nearest) continue;  // of another surface
      const double weight = (i == 0 ? 1.0 - a : a) * (j == 0 ? 1.0 - b : b) + 1e-9;
      weights += weight;
      depths += weight * depth;
    }
  }
  Eigen::Vector3d bearing;
  if (!Unproject(intrinsics, pixel, &bearing)) return false;
  *position = pose.T_map_camera(pixel.y()) * (depths / weights * bearing);
  return true;
}

}  // namespace mlic
