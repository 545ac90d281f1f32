#pragma once

#include <Eigen/Core>
#include <cstddef>

namespace mlic {

// How the IMU stands over the ground: R_ground_imu = Ry(pitch) Rx(roll), ground's z along its normal.
struct PoseOverGround {
  struct Angles {
    double height = 0.0;  // m, of the IMU's origin
    double roll = 0.0;    // rad
    double pitch = 0.0;
  };
  Angles mean;
  Angles scatter;                                 // standard deviation over the drive, of single places
  Angles sigma;                                   // of the mean
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();  // the ground's mean normal in the frame of the IMU
  std::size_t places = 0;                         // along the trajectory where the map shows the ground
};

}  // namespace mlic
