#include <gtest/gtest.h>

#include <vector>

#include "mlic_core/common/random.h"
#include "mlic_core/factors/imu_residual.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/problem/state.h"
#include "mlic_core/sensors/imu_matrices.h"

namespace mlic::imu_axes_test {
namespace {

Eigen::Vector3d RandomVector(Random* random) {
  return {random->Normal(), random->Normal(), random->Normal()};
}

// An accelerometer turned against its gyroscope by some 3 deg, both sheared, and one LiDAR.
class TurnedImu : public testing::Test {
 protected:
  TurnedImu() {
    Random random(4);
    const UniformKnots knots = UniformKnots::Covering(0.0, 1.0, 0.2);
    std::vector<Eigen::Quaterniond> rotations;
    std::vector<Eigen::Vector3d> positions;
    for (int i = 0; i < knots.count; ++i) {
      rotations.push_back(ExpQuaternion(0.3 * RandomVector(&random)));
      positions.push_back(0.2 * RandomVector(&random));
    }
    state_.drives.resize(1);
    state_.drives[0].trajectory = {So3Spline(knots, rotations), PositionSpline(knots, positions)};
    state_.lidars.resize(1);
    state_.lidars[0].T_imu_sensor = {ExpQuaternion(RandomVector(&random)), RandomVector(&random)};
    state_.gyroscope_matrix << 1.003, 0.0, 0.0, -0.002, 0.996, 0.0, 0.004, -0.003, 1.002;
    state_.accelerometer_matrix << 0.997, 0.0, 0.0, 0.003, 1.002, 0.0, -0.003, 0.001, 1.004;
    state_.accelerometer_matrix = ExpMatrix(turn_) * state_.accelerometer_matrix;
  }
  Eigen::Matrix<double, 6, 1> Measured(double time) const {
    const SplitSpline& trajectory = state_.drives[0].trajectory;
    return ImuResidual::Evaluate(trajectory, {trajectory, time, 0.0}, state_.Imu(0, time), state_.Gravity(),
                                 {time, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()}, nullptr);
  }
  RigidTransform PoseOfLidar(double time) const {
    return state_.drives[0].trajectory.Pose(time) * state_.lidars[0].T_imu_sensor;
  }

  const Eigen::Vector3d turn_{0.03, -0.02, 0.04};
  CalibrationState state_;
};

TEST_F(TurnedImu, MeasuresTheSameInAllAxes) {
  const Eigen::Vector3d axis = Eigen::Vector3d(0.1, -0.2, 1.0).normalized();
  const CalibrationState before = state_;
  const Eigen::Matrix<double, 6, 1> measured = Measured(0.43);
  const RigidTransform pose = PoseOfLidar(0.43);
  SetAccelerometerAxes(axis * axis.transpose(), &state_);
  EXPECT_LT((Measured(0.43) - measured).norm(), 1e-12);
  EXPECT_LT((PoseOfLidar(0.43).translation - pose.translation).norm(), 1e-12);
  EXPECT_LT(PoseOfLidar(0.43).rotation.angularDistance(pose.rotation), 1e-7);
  // About the axis the accelerometer is not turned against the IMU, the gyroscope about no other.
  const Eigen::Vector3d of_accelerometer =
      Log(SplitAccelerometerMatrix(state_.accelerometer_matrix).rotation);
  const Eigen::Vector3d of_gyroscope = Log(SplitGyroscopeMatrix(state_.gyroscope_matrix).rotation);
  EXPECT_LT(std::abs(axis.dot(of_accelerometer)), 5e-4);  // triangles do not quite commute with rotations
  EXPECT_LT(axis.cross(of_gyroscope).norm(), 1e-12);
  EXPECT_NEAR(axis.dot(of_gyroscope), -axis.dot(turn_), 1e-3);
  SetAccelerometerAxes(Eigen::Matrix3d::Zero(), &state_);
  EXPECT_LT((state_.gyroscope_matrix - before.gyroscope_matrix).norm(), 1e-12);
  EXPECT_LT((state_.accelerometer_matrix - before.accelerometer_matrix).norm(), 1e-12);
  EXPECT_LT((state_.lidars[0].T_imu_sensor.translation - before.lidars[0].T_imu_sensor.translation).norm(),
            1e-12);
}

TEST_F(TurnedImu, IsTheAccelerometersInAllThreeAxes) {
  SetAccelerometerAxes(Eigen::Matrix3d::Identity(), &state_);
  EXPECT_LT(Log(SplitAccelerometerMatrix(state_.accelerometer_matrix).rotation).norm(), 5e-4);
  EXPECT_LT((Log(SplitGyroscopeMatrix(state_.gyroscope_matrix).rotation) + turn_).norm(), 5e-4);
}

}  // namespace
}  // namespace mlic::imu_axes_test
