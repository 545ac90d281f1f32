#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <opencv2/core/mat.hpp>

#include "mlic_core/geometry/rigid_transform.h"
#include "mlic_core/sensors/camera_model.h"
#include "mlic_core/sensors/rig.h"
#include "mlic_core/trajectory/split_spline.h"

namespace mlic {

// Where a camera was while it took one image: T_map_camera at the time of an image row. A global shutter has
// the same pose at all rows.
struct ViewPose {
  std::function<RigidTransform(double row)> T_map_camera;
  bool rolling = false;
};

// A camera on the trajectory. image_time: of row 0, camera clock; readout: s, from row 0 to the row below the
// last of `height`; 0 for a global shutter. The trajectory must outlive the pose.
ViewPose PoseOnTrajectory(const SplitSpline& trajectory, const SensorCalibration& camera, double image_time,
                          double readout, int height);
ViewPose FixedPose(const RigidTransform& T_map_camera);

// The map as a camera sees it. All images have the camera's size and its pixels.
struct RenderedView {
  cv::Mat intensity;  // CV_32F, 0 to 1; not a number where nothing is seen
  cv::Mat depth;      // CV_32F, distance along the ray (not z), m; 0 where nothing is seen
  cv::Mat normal;     // CV_32FC3, unit, map frame, towards the camera; zero where there is no plane
  cv::Mat point;      // CV_32S, index in the map's points of the one nearest to the pixel; -1 for none
  cv::Mat spacing;    // CV_32F, m, between the map's points there; 0 where nothing is seen

  bool IsSeen(int column, int row) const { return point.at<std::int32_t>(row, column) >= 0; }
};

// The place on the map's surface that a pixel shows, map frame: its bearing at the view's depth there. False
// where nothing is seen. Sub-pixel: depth is interpolated between neighbours of one surface.
bool SurfaceAt(const RenderedView& view, const CameraIntrinsics& intrinsics, const ViewPose& pose,
               const Eigen::Vector2d& pixel, Eigen::Vector3d* position);

}  // namespace mlic
