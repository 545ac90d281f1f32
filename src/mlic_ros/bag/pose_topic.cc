#include "mlic_ros/bag/pose_topic.h"

#include <geometry_msgs/PoseStamped.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <geometry_msgs/TransformStamped.h>
#include <nav_msgs/Odometry.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "mlic_core/common/error.h"

namespace mlic {
namespace {

template <typename Translation, typename Rotation>
std::optional<StampedPose> Stamped(const ros::Time& stamp, const Translation& p, const Rotation& q) {
  const Eigen::Quaterniond rotation(q.w, q.x, q.y, q.z);
  const Eigen::Vector3d translation(p.x, p.y, p.z);
  if (!translation.allFinite() || !(std::abs(rotation.norm() - 1.0) < 0.01)) return std::nullopt;
  return StampedPose{static_cast<TimeNs>(stamp.toNSec()), {rotation.normalized(), translation}};
}

std::optional<StampedPose> PoseOf(const rosbag::MessageInstance& instance) {
  if (const auto m = instance.instantiate<nav_msgs::Odometry>()) {
    return Stamped(m->header.stamp, m->pose.pose.position, m->pose.pose.orientation);
  }
  if (const auto m = instance.instantiate<geometry_msgs::PoseStamped>()) {
    return Stamped(m->header.stamp, m->pose.position, m->pose.orientation);
  }
  if (const auto m = instance.instantiate<geometry_msgs::PoseWithCovarianceStamped>()) {
    return Stamped(m->header.stamp, m->pose.pose.position, m->pose.pose.orientation);
  }
  if (const auto m = instance.instantiate<geometry_msgs::TransformStamped>()) {
    return Stamped(m->header.stamp, m->transform.translation, m->transform.rotation);
  }
  return std::nullopt;
}

bool IsPoseType(const std::string& type) {
  return type == "nav_msgs/Odometry" || type == "geometry_msgs/PoseStamped" ||
         type == "geometry_msgs/PoseWithCovarianceStamped" || type == "geometry_msgs/TransformStamped";
}

}  // namespace

std::vector<StampedPose> ReadPoseTopic(const BagSet& bags, const std::string& topic) {
  const auto found = bags.topics().find(topic);
  if (found == bags.topics().end()) {
    throw InputError("bag " + bags.names() + ": no topic " + topic +
                     " (--reference-topic); the topics are: " + bags.ListTopics());
  }
  if (!IsPoseType(found->second.type)) {
    throw InputError("bag " + bags.names() + ": topic " + topic + " (--reference-topic) is of type " +
                     found->second.type +
                     ", expected nav_msgs/Odometry, geometry_msgs/PoseStamped, "
                     "geometry_msgs/PoseWithCovarianceStamped or geometry_msgs/TransformStamped");
  }
  std::vector<StampedPose> poses;
  try {
    const auto view = bags.Messages({topic}, bags.interval());
    for (const rosbag::MessageInstance& instance : *view) {
      if (const auto pose = PoseOf(instance)) poses.push_back(*pose);
    }
  } catch (const std::exception& error) {
    throw InputError("bag " + bags.names() + ": damaged in topic " + topic + " (" + error.what() +
                     "); try `rosbag reindex`");
  }
  if (poses.empty()) {
    throw InputError("topic " + topic + ": none of its messages holds a finite pose with a unit quaternion");
  }
  std::stable_sort(poses.begin(), poses.end(), [](const auto& a, const auto& b) { return a.time < b.time; });
  poses.erase(
      std::unique(poses.begin(), poses.end(), [](const auto& a, const auto& b) { return a.time == b.time; }),
      poses.end());
  return poses;
}

}  // namespace mlic
