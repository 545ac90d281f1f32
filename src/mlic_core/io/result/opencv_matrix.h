#pragma once

#include <opencv2/core.hpp>

#include "mlic_core/geometry/rigid_transform.h"

namespace mlic {

// The 4 x 4 matrix of a pose, for cv::FileStorage.
inline cv::Mat HomogeneousMatrix(const RigidTransform& pose) {
  const Eigen::Matrix3d R = pose.rotation.toRotationMatrix();
  const Eigen::Vector3d& t = pose.translation;
  return cv::Mat(cv::Matx44d(R(0, 0), R(0, 1), R(0, 2), t.x(), R(1, 0), R(1, 1), R(1, 2), t.y(), R(2, 0),
                             R(2, 1), R(2, 2), t.z(), 0, 0, 0, 1));
}

}  // namespace mlic
