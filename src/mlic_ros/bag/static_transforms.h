#pragma once

#include <tf2/buffer_core.h>

#include <optional>
#include <string>

#include "mlic_core/geometry/rigid_transform.h"
#include "mlic_ros/bag/bag_set.h"

namespace mlic {

// The fixed transforms of the bags: those of /tf_static, and those of /tf that are published again and again
// without ever changing, as joint publishers of old do with fixed joints. Where both name a frame, /tf_static
// counts.
class StaticTransforms {
 public:
  explicit StaticTransforms(const BagSet& bags);

  bool empty() const { return empty_; }
  // T_a_b, where the tree links the two frames.
  std::optional<RigidTransform> Find(const std::string& a, const std::string& b) const;

 private:
  void Add(geometry_msgs::TransformStamped transform);

  tf2::BufferCore buffer_;
  bool empty_ = true;
};

}  // namespace mlic
