#pragma once

#include <map>
#include <optional>
#include <string>

#include "mlic_core/geometry/rigid_transform.h"
#include "mlic_ros/bag/bag_set.h"

namespace mlic {

// The tree of /tf_static.
class StaticTransforms {
 public:
  explicit StaticTransforms(const BagSet& bags);

  bool empty() const { return parents_.empty(); }
  // T_a_b, where the tree links the two frames.
  std::optional<RigidTransform> Find(const std::string& a, const std::string& b) const;

 private:
  struct Parent {
    std::string frame;
    RigidTransform T_parent_child;
  };
  // T_ancestor_frame for every ancestor of the frame, itself included.
  std::map<std::string, RigidTransform> Ancestors(std::string frame) const;

  std::map<std::string, Parent> parents_;
};

}  // namespace mlic
