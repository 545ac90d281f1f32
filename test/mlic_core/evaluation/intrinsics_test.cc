#include <gtest/gtest.h>

#include <cmath>

#include "mlic_core/evaluation/intrinsics_error.h"

namespace mlic::intrinsics_test {
namespace {

CalibrationResult OneCamera(CameraModel model, const std::vector<double>& parameters) {
  CalibrationResult result;
  result.sensors.resize(1);
  result.sensors[0].name = "camera";
  result.sensors[0].type = SensorResult::Type::kCamera;
  result.sensors[0].intrinsics = CameraIntrinsics{model, 1000, 800, parameters};
  return result;
}

CalibrationResult Pinhole(double f, double cx, double k1) {
  return OneCamera(CameraModel::kPlumbBob, {f, f, cx, 399.5, k1, 0.0, 0.0, 0.0, 0.0});
}

TEST(IntrinsicsError, ItselfHasNone) {
  const auto errors = CompareIntrinsics(Pinhole(600.0, 499.5, -0.05), Pinhole(600.0, 499.5, -0.05));
  ASSERT_EQ(errors.size(), 1u);
  EXPECT_LT(errors[0].largest, 1e-6);
  EXPECT_EQ(errors[0].covered, 1.0);
}

TEST(IntrinsicsError, AShiftedCentreIsMostlyARotation) {
  const auto errors = CompareIntrinsics(Pinhole(600.0, 502.5, 0.0), Pinhole(600.0, 499.5, 0.0));
  EXPECT_NEAR(errors[0].mean, 3.0, 1e-6);
  EXPECT_NEAR(errors[0].largest, 3.0, 1e-6);
  EXPECT_LT(errors[0].mean_after_rotation, 1.0);
}

TEST(IntrinsicsError, AFocalLengthGrowsWithTheRadiusAndIsNoRotation) {
  const auto errors = CompareIntrinsics(Pinhole(606.0, 499.5, 0.0), Pinhole(600.0, 499.5, 0.0));
  EXPECT_NEAR(errors[0].largest, std::hypot(499.5, 399.5) * 6.0 / 606.0, 1e-6);
  EXPECT_NEAR(errors[0].mean_after_rotation, errors[0].mean, 1e-3);
}

TEST(IntrinsicsError, ModelsMayDiffer) {
  // Equidistant with its first terms zero is not a pinhole; the same camera in another model is itself.
  CalibrationResult rational =
      OneCamera(CameraModel::kRationalPolynomial,
                {600.0, 600.0, 499.5, 399.5, -0.05, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0});
  EXPECT_LT(CompareIntrinsics(rational, Pinhole(600.0, 499.5, -0.05))[0].largest, 1e-6);
  const CalibrationResult fisheye =
      OneCamera(CameraModel::kEquidistant, {600.0, 600.0, 499.5, 399.5, 0.0, 0.0, 0.0, 0.0});
  EXPECT_GT(CompareIntrinsics(fisheye, Pinhole(600.0, 499.5, 0.0))[0].mean, 10.0);
}

TEST(IntrinsicsError, ReadoutsAndMissingIntrinsics) {
  CalibrationResult estimate = Pinhole(600.0, 499.5, 0.0), truth = estimate;
  estimate.sensors[0].rolling_shutter_readout = 0.0203;
  EXPECT_FALSE(CompareIntrinsics(estimate, truth)[0].readout.has_value());
  truth.sensors[0].rolling_shutter_readout = 0.02;
  const auto errors = CompareIntrinsics(estimate, truth);
  EXPECT_NEAR(*errors[0].readout, 0.0003, 1e-12);
  EXPECT_NE(TableOf(errors).find("readout off by 0.3000 ms"), std::string::npos);
  EXPECT_NE(CsvOf(errors).find("\ncamera,1.000000,0.000000"), std::string::npos);
  truth.sensors[0].intrinsics.reset();
  EXPECT_TRUE(CompareIntrinsics(estimate, truth).empty());
}

}  // namespace
}  // namespace mlic::intrinsics_test
