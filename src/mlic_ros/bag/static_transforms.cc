#include "mlic_ros/bag/static_transforms.h"

#include <tf2_msgs/TFMessage.h>

namespace mlic {
namespace {

// tf of old wrote frames with a leading slash.
std::string WithoutSlash(const std::string& frame) {
  return !frame.empty() && frame.front() == '/' ? frame.substr(1) : frame;
}

}  // namespace

StaticTransforms::StaticTransforms(const BagSet& bags) {
  const auto view = bags.Messages({"/tf_static"}, bags.interval());
  for (const rosbag::MessageInstance& instance : *view) {
    const auto message = instance.instantiate<tf2_msgs::TFMessage>();
    if (message == nullptr) continue;
    for (const auto& transform : message->transforms) {
      const auto& q = transform.transform.rotation;
      const auto& t = transform.transform.translation;
      const RigidTransform pose{Eigen::Quaterniond(q.w, q.x, q.y, q.z).normalized(), {t.x, t.y, t.z}};
      parents_[WithoutSlash(transform.child_frame_id)] = {WithoutSlash(transform.header.frame_id), pose};
    }
  }
}

std::map<std::string, RigidTransform> StaticTransforms::Ancestors(std::string frame) const {
  std::map<std::string, RigidTransform> ancestors{{frame, {}}};
  RigidTransform pose;
  for (auto at = parents_.find(frame); at != parents_.end(); at = parents_.find(frame)) {
    pose = at->second.T_parent_child * pose;
    frame = at->second.frame;
    if (!ancestors.emplace(frame, pose).second) break;  // a loop
  }
  return ancestors;
}

std::optional<RigidTransform> StaticTransforms::Find(const std::string& a, const std::string& b) const {
  const auto above_a = Ancestors(WithoutSlash(a));
  const auto above_b = Ancestors(WithoutSlash(b));
  for (const auto& [frame, T_frame_a] : above_a) {
    const auto common = above_b.find(frame);
    if (common != above_b.end()) return T_frame_a.Inverse() * common->second;
  }
  return std::nullopt;
}

}  // namespace mlic
