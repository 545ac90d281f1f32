#include "mlic_ros/display/round_projection.h"

#include <gtest/gtest.h>

#include "mlic_core/sensors/camera_model.h"

namespace mlic::round_projection_test {
namespace {

MapPoint At(float x, float y, float z) {
  MapPoint point;
  point.position = Eigen::Vector3f(x, y, z);
  return point;
}

TEST(RoundProjection, KeepsWhatTheCameraSeesAndNotWhatIsBehind) {
  const CameraIntrinsics camera = IntrinsicsFromFieldOfView(CameraModel::kPlumbBob, 640, 480, 90.0);
  RigidTransform T_map_camera;  // looks along z
  T_map_camera.translation = {0.0, 0.0, 1.0};
  std::vector<MapPoint> points{At(0.0f, 0.0f, 4.0f), At(0.0f, 0.0f, 9.0f), At(4.0f, 0.0f, 9.0f),
                               At(0.0f, 0.0f, -4.0f), At(30.0f, 0.0f, 9.0f)};
  const std::vector<ProjectedPoint> seen = ProjectMap(points, T_map_camera, camera);
  ASSERT_EQ(seen.size(), 2u) << "hidden, behind the camera, or outside of the image";
  EXPECT_NEAR(seen[0].depth, 3.0f, 1e-6f);
  EXPECT_NEAR(seen[0].pixel.x(), 319.5f, 1.0f);
  EXPECT_NEAR(seen[1].pixel.x(), 319.5f + 0.5f * 320.0f, 1.0f);
}

TEST(RoundProjection, ASurfaceDoesNotHideItself) {
  const CameraIntrinsics camera = IntrinsicsFromFieldOfView(CameraModel::kPlumbBob, 640, 480, 90.0);
  std::vector<MapPoint> wall;
  for (int i = -20; i <= 20; ++i) {
    for (int j = -15; j <= 15; ++j) {
      wall.push_back(At(0.1f * static_cast<float>(i), 0.1f * static_cast<float>(j),
                        3.0f + 0.02f * static_cast<float>(i)));
    }
  }
  EXPECT_EQ(ProjectMap(wall, {}, camera).size(), wall.size());
}

}  // namespace
}  // namespace mlic::round_projection_test
