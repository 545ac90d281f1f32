#pragma once

#include <vector>

#include "mlic_core/problem/joint_problem.h"
#include "mlic_core/problem/state.h"

namespace mlic {

// LiDARs and an IMU in one place, which stand still for so many seconds; no planes yet. The dataset must
// outlive the problem.
inline void PlaceAtRest(int seconds, std::size_t lidars, Dataset* dataset, JointProblem* problem,
                        CalibrationState* state) {
  const UniformKnots knots = UniformKnots::Covering(-0.5, seconds + 0.5, 0.5);
  DriveState drive;
  drive.trajectory.rotation =
      So3Spline(knots, std::vector<Eigen::Quaterniond>(knots.count, Eigen::Quaterniond::Identity()));
  drive.trajectory.position =
      PositionSpline(knots, std::vector<Eigen::Vector3d>(knots.count, Eigen::Vector3d::Zero()));
  state->drives = {drive};
  state->lidars.resize(lidars);
  dataset->drives.resize(1);
  for (int i = 0; i < 50 * seconds; ++i) {
    dataset->drives[0].imu.push_back({i / 50.0, Eigen::Vector3d::Zero(), -state->Gravity()});
  }
  problem->dataset = dataset;
  problem->drives.resize(1);
  problem->drives[0].imu_sigma.usual = {Eigen::Vector3d::Constant(1e-4), Eigen::Vector3d::Constant(3e-4)};
  problem->drives[0].planes.begin = {0};
  problem->lidars.resize(lidars);
}

}  // namespace mlic
