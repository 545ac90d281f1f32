#include "mlic_core/crossmodal/projection_table.h"

#include <algorithm>
#include <limits>

namespace mlic {
namespace {

// The largest coordinate of q that the image shows.
double ExtentOf(const CameraIntrinsics& intrinsics) {
  constexpr double kMost = 3.0;  // 143 deg from the axis; from: structural, what the table covers
  double extent = 0.05;
  const auto look = [&](double u, double v) {
    Eigen::Vector3d bearing;
    if (!Unproject(intrinsics, {u, v}, &bearing)) return;
    extent = std::max(extent, bearing.head<2>().cwiseAbs().maxCoeff() / std::max(1e-3, 1.0 + bearing.z()));
  };
  // All over the image, for the corners of a fisheye's image may show nothing.
  constexpr int kSteps = 40;  // from: structural, what the table covers
  for (int i = 0; i <= kSteps; ++i) {
    for (int j = 0; j <= kSteps; ++j) {
      look((intrinsics.width - 1.0) * i / kSteps, (intrinsics.height - 1.0) * j / kSteps);
    }
  }
  return std::min(kMost, 1.05 * extent);
}

}  // namespace

ProjectionTable::ProjectionTable(const CameraIntrinsics& intrinsics) {
  const double extent = ExtentOf(intrinsics);
  extent_ = static_cast<float>(extent);
  per_unit_ = static_cast<float>(0.5 * kCells / extent);
  nodes_.resize((kCells + 1) * (kCells + 1));
  for (int j = 0; j <= kCells; ++j) {
    for (int i = 0; i <= kCells; ++i) {
      const Eigen::Vector2d q(extent * (2.0 * i / kCells - 1.0), extent * (2.0 * j / kCells - 1.0));
      // The bearing that stereographic projection takes to q.
      const Eigen::Vector3d bearing(2.0 * q.x(), 2.0 * q.y(), 1.0 - q.squaredNorm());
      Eigen::Vector2d pixel;
      Node& node = nodes_[j * (kCells + 1) + i];
      if (mlic::Project(intrinsics, bearing, &pixel)) {
        node = {static_cast<float>(pixel.x()), static_cast<float>(pixel.y())};
      } else {
        node.u = node.v = std::numeric_limits<float>::quiet_NaN();
      }
    }
  }
}

}  // namespace mlic
