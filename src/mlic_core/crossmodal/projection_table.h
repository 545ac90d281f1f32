#pragma once

#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "mlic_core/sensors/camera_model.h"

namespace mlic {

// A camera model as a table over the stereographic plane q = (x, y) / (|p| + z), interpolated linearly: the
// same cost for all models, no trigonometry, and accurate to some hundredths of a pixel. It holds past 90 deg
// from the axis. The plane is conformal: lengths across the ray at distance |p| shrink by
// (1 + |q|^2) / (2 |p|) in all directions alike.
class ProjectionTable {
 public:
  explicit ProjectionTable(const CameraIntrinsics& intrinsics);

  struct Pixel {
    float u, v;
    float qx, qy;
    float u_x, u_y, v_x, v_y;  // derivatives to q
  };

  // False where the camera does not see. range: |p|.
  bool Project(const Eigen::Vector3f& p, float range, Pixel* pixel) const {
    const float s = 1.0f / (range + p.z());
    pixel->qx = p.x() * s;
    pixel->qy = p.y() * s;
    const float x = (pixel->qx + extent_) * per_unit_, y = (pixel->qy + extent_) * per_unit_;
    if (!(x >= 0.0f && y >= 0.0f && x < kCells && y < kCells)) return false;
    const int i = static_cast<int>(x), j = static_cast<int>(y);
    const float a = x - i, b = y - j;
    const Node *n0 = &nodes_[j * (kCells + 1) + i], *n1 = n0 + kCells + 1;
    const float du0 = n0[1].u - n0[0].u, du1 = n1[1].u - n1[0].u;
    const float dv0 = n0[1].v - n0[0].v, dv1 = n1[1].v - n1[0].v;
    const float u0 = n0[0].u + a * du0, u1 = n1[0].u + a * du1;
    const float v0 = n0[0].v + a * dv0, v1 = n1[0].v + a * dv1;
    pixel->u = u0 + b * (u1 - u0);
    pixel->v = v0 + b * (v1 - v0);
    pixel->u_x = (du0 + b * (du1 - du0)) * per_unit_;
    pixel->v_x = (dv0 + b * (dv1 - dv0)) * per_unit_;
    pixel->u_y = (u1 - u0) * per_unit_;
    pixel->v_y = (v1 - v0) * per_unit_;
    return std::isfinite(pixel->u);
  }

 private:
  struct Node {
    float u, v;  // not a number where the model does not hold
  };
  static constexpr int kCells = 1024;  // from: structural

  float extent_ = 1.0f;  // the table covers q from -extent to +extent
  float per_unit_ = 1.0f;
  std::vector<Node> nodes_;
};

}  // namespace mlic
