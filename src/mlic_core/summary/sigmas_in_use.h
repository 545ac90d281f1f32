#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "mlic_core/geometry/rigid_transform.h"
#include "mlic_core/problem/state.h"
#include "mlic_core/result/result.h"
#include "mlic_core/sensors/camera_intrinsics.h"
#include "mlic_core/sensors/rig.h"
#include "mlic_core/uncertainty/observability.h"

namespace mlic {

// A pose T_a_b, and what is known of it: the covariance of a small left rotation (rad) and of the translation
// (m), then, for those that are not null, of the intrinsics of a and of b.
struct UncertainPose {
  RigidTransform T_a_b;
  const CameraIntrinsics* a = nullptr;
  const CameraIntrinsics* b = nullptr;
  Eigen::MatrixXd covariance;
};

// Where points at 10 and at 50 m from b come to lie in the frame of a. R_a_vehicle: vehicle_axes.h.
std::vector<SigmaInUse> SigmasInSpace(const UncertainPose& pose, const Eigen::Matrix3d& R_a_vehicle);

// Where points at 10 and at 50 m from the camera b come to lie in its image: those that a has in its frame
// or, if it is a camera, sees in its image at a known distance. Without distances at which it sees none.
std::vector<SigmaInUse> SigmasInImage(const UncertainPose& pose);

// Of the sensors at two places of the order. R_vehicle_body: of what T_imu_sensor is about.
std::vector<SigmaInUse> SigmasOfPair(const CalibrationState& state, const ObservabilityAnalysis& analysis,
                                     std::size_t a, std::size_t b, const Eigen::Matrix3d& R_vehicle_body);

// Of all sensors, against the IMU, and all pairs that are given.
void AddSigmasInUse(const Rig& rig, const CalibrationState& state, const ObservabilityAnalysis& analysis,
                    CalibrationResult* result);

}  // namespace mlic
