#pragma once

#include <string>

#include "mlic_core/io/result/sensor_tree.h"

namespace mlic {

// The package whose static_transform_publisher is started. Both take x y z qx qy qz qw PARENT CHILD; that of
// tf also a period, and publishes on /tf.
enum class TransformPublisher { kTf2, kTf };

// A launch file that publishes every frame's pose in the parent, one static_transform_publisher each
// (roslaunch splits the arguments as a shell does). roslaunch runs it as it is.
std::string StaticTransformsText(const SensorTree& tree, TransformPublisher publisher);

}  // namespace mlic
