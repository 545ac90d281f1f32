#include "mlic_ros/bag/static_transforms.h"

#include <tf2/exceptions.h>
#include <tf2_msgs/TFMessage.h>

#include <cmath>
#include <functional>
#include <map>
#include <set>

namespace mlic {
namespace {

using geometry_msgs::TransformStamped;

// m and rad, from: guard; what publishers that compute a fixed joint anew each time differ by is rounding.
constexpr double kFixed = 1e-6;

// tf of old wrote frames with a leading slash, which tf2 refuses.
std::string WithoutSlash(const std::string& frame) {
  return !frame.empty() && frame.front() == '/' ? frame.substr(1) : frame;
}

RigidTransform PoseOf(const TransformStamped& transform) {
  const auto& q = transform.transform.rotation;
  const auto& t = transform.transform.translation;
  return {Eigen::Quaterniond(q.w, q.x, q.y, q.z).normalized(), {t.x, t.y, t.z}};
}

void ForEach(const BagSet& bags, const std::string& topic,
             const std::function<void(const TransformStamped&)>& work) {
  const auto view = bags.Messages({topic}, bags.interval());
  for (const rosbag::MessageInstance& instance : *view) {
    const auto message = instance.instantiate<tf2_msgs::TFMessage>();
    if (message == nullptr) continue;
    for (const TransformStamped& transform : message->transforms) {
      if (PoseOf(transform).rotation.coeffs().allFinite() && PoseOf(transform).translation.allFinite()) {
        work(transform);
      }
    }
  }
}

// A frame of /tf: what was said of it first, how often, and whether always the same.
struct Joint {
  TransformStamped first;
  int messages = 0;
  bool fixed = true;
};

bool AreAlike(const TransformStamped& a, const TransformStamped& b) {
  const RigidTransform difference = PoseOf(a).Inverse() * PoseOf(b);
  return a.header.frame_id == b.header.frame_id && difference.translation.norm() < kFixed &&
         2.0 * difference.rotation.vec().norm() < kFixed;
}

}  // namespace

StaticTransforms::StaticTransforms(const BagSet& bags) {
  std::set<std::string> in_tf_static;
  ForEach(bags, "/tf_static", [&](const TransformStamped& transform) {
    in_tf_static.insert(WithoutSlash(transform.child_frame_id));
    Add(transform);
  });
  std::map<std::string, Joint> joints;
  ForEach(bags, "/tf", [&](const TransformStamped& transform) {
    Joint& joint = joints[transform.child_frame_id];
    if (joint.messages++ == 0) joint.first = transform;
    joint.fixed = joint.fixed && AreAlike(joint.first, transform);
  });
  for (const auto& [child, joint] : joints) {
    // What was said only once may as well move.
    if (joint.fixed && joint.messages > 1 && in_tf_static.count(WithoutSlash(child)) == 0) Add(joint.first);
  }
}

void StaticTransforms::Add(TransformStamped transform) {
  transform.header.frame_id = WithoutSlash(transform.header.frame_id);
  transform.child_frame_id = WithoutSlash(transform.child_frame_id);
  if (transform.header.frame_id.empty() || transform.child_frame_id.empty() ||
      transform.header.frame_id == transform.child_frame_id) {
    return;
  }
  const Eigen::Quaterniond rotation = PoseOf(transform).rotation;  // tf2 takes unit quaternions only
  transform.transform.rotation.w = rotation.w();
  transform.transform.rotation.x = rotation.x();
  transform.transform.rotation.y = rotation.y();
  transform.transform.rotation.z = rotation.z();
  constexpr bool kIsStatic = true;
  if (buffer_.setTransform(transform, "bag", kIsStatic)) empty_ = false;
}

std::optional<RigidTransform> StaticTransforms::Find(const std::string& a, const std::string& b) const {
  try {
    return PoseOf(buffer_.lookupTransform(WithoutSlash(a), WithoutSlash(b), ros::Time(0)));
  } catch (const tf2::TransformException&) {
    return std::nullopt;
  }
}

}  // namespace mlic
