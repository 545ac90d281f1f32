#include "mlic_ros/display/round_projection.h"

#include <algorithm>
#include <cmath>

#include "mlic_core/sensors/camera_model.h"

namespace mlic {
namespace {

// Constants of this file, from: structural, how RViz shows it.

constexpr int kCells = 80;        // along the image's width
constexpr double kBehind = 1.15;  // times the depth of the nearest point around: hidden by it

// The depths of the nearest points in cells of the image.
class NearestDepths {
 public:
  explicit NearestDepths(const CameraIntrinsics& camera)
      : cell_(std::max(1, camera.width / kCells)),
        columns_(camera.width / cell_ + 1),
        depths_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(camera.height / cell_ + 1),
                HUGE_VALF) {}

  void Add(const ProjectedPoint& point) {
    float& nearest = depths_[Cell(Column(point), Row(point))];
    nearest = std::min(nearest, point.depth);
  }

  // Of the point's cell and those beside it.
  float Around(const ProjectedPoint& point) const {
    const int rows = static_cast<int>(depths_.size()) / columns_;
    const int column = Column(point), row = Row(point);
    float nearest = HUGE_VALF;
    for (int r = std::max(0, row - 1); r <= std::min(rows - 1, row + 1); ++r) {
      for (int c = std::max(0, column - 1); c <= std::min(columns_ - 1, column + 1); ++c) {
        nearest = std::min(nearest, depths_[Cell(c, r)]);
      }
    }
    return nearest;
  }

 private:
  int Column(const ProjectedPoint& point) const { return static_cast<int>(point.pixel.x()) / cell_; }
  int Row(const ProjectedPoint& point) const { return static_cast<int>(point.pixel.y()) / cell_; }
  std::size_t Cell(int column, int row) const { return static_cast<std::size_t>(row * columns_ + column); }

  int cell_, columns_;
  std::vector<float> depths_;
};

}  // namespace

std::vector<ProjectedPoint> ProjectMap(const std::vector<MapPoint>& points,
                                       const RigidTransform& T_map_camera,
                                       const CameraIntrinsics& intrinsics) {
  const RigidTransform T_camera_map = T_map_camera.Inverse();
  NearestDepths nearest(intrinsics);
  std::vector<ProjectedPoint> inside;
  for (const MapPoint& point : points) {
    const Eigen::Vector3d p = T_camera_map * point.position.cast<double>();
    Eigen::Vector2d pixel;
    if (!Project(intrinsics, p, &pixel)) continue;
    if (!(pixel.x() >= 0.0 && pixel.y() >= 0.0 && pixel.x() < intrinsics.width &&
          pixel.y() < intrinsics.height)) {
      continue;
    }
    inside.push_back({pixel.cast<float>(), static_cast<float>(p.norm()), point.intensity});
    nearest.Add(inside.back());
  }
  const auto hidden = [&](const ProjectedPoint& point) {
    return point.depth > kBehind * nearest.Around(point);
  };
  inside.erase(std::remove_if(inside.begin(), inside.end(), hidden), inside.end());
  return inside;
}

}  // namespace mlic
