#include "mlic_core/sensors/imu_matrices.h"

#include <gtest/gtest.h>

#include "mlic_core/geometry/so3.h"

namespace mlic::imu_matrices_test {
namespace {

Eigen::Matrix3d Triangle() {
  Eigen::Matrix3d triangle;
  triangle << 1.01, 0.0, 0.0, 0.02, 0.99, 0.0, -0.03, 0.01, 1.02;
  return triangle;
}

TEST(ImuMatrices, ArePutTogetherAgainFromTheirParts) {
  const Eigen::Matrix3d rotation = ExpMatrix(Eigen::Vector3d(0.3, -0.8, 1.1));
  const RotationAndTriangle accelerometer = SplitAccelerometerMatrix(rotation * Triangle());
  EXPECT_LT((accelerometer.rotation - rotation).norm(), 1e-14);
  EXPECT_LT((accelerometer.triangle - Triangle()).norm(), 1e-14);
  const RotationAndTriangle gyroscope = SplitGyroscopeMatrix(Triangle() * rotation);
  EXPECT_LT((gyroscope.rotation - rotation).norm(), 1e-14);
  EXPECT_LT((gyroscope.triangle - Triangle()).norm(), 1e-14);
}

}  // namespace
}  // namespace mlic::imu_matrices_test
