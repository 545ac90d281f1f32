#pragma once

#include <string>
#include <vector>

#include "mlic_core/result/result.h"
#include "mlic_ros/bag/bag_set.h"

namespace mlic {

// The poses of a topic of nav_msgs/Odometry, geometry_msgs/PoseStamped, PoseWithCovarianceStamped or
// TransformStamped, at their header stamps, in order of time; of several messages with one stamp the first.
// Poses that are not finite or have no unit quaternion are left out. InputError for a topic that is absent,
// of another type, or without usable poses.
std::vector<StampedPose> ReadPoseTopic(const BagSet& bags, const std::string& topic);

}  // namespace mlic
