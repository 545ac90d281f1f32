#include "mlic_core/camera/model_fit.h"

#include <gtest/gtest.h>

#include <cmath>

namespace mlic::model_fit_test {
namespace {

double SumOfSquares(const CameraIntrinsics& camera, const std::vector<PixelRay>& rays) {
  double sum = 0.0;
  for (const PixelRay& ray : rays) {
    Eigen::Vector2d pixel;
    if (!Project(camera, ray.bearing, &pixel)) return 1e12;
    sum += (pixel - ray.pixel).squaredNorm();
  }
  return sum;
}

CameraIntrinsics StartOf(const CameraIntrinsics& truth) {
  CameraIntrinsics start = truth;
  for (std::size_t i = 4; i < start.parameters.size(); ++i) start.parameters[i] = 0.0;
  start.parameters[0] *= 1.05;
  start.parameters[2] += 9.0;
  if (truth.model == CameraModel::kDoubleSphere) start.parameters[5] = 0.5;
  return start;
}

TEST(FitToRays, RaysOfAModelGiveItsParameters) {
  const CameraIntrinsics cameras[] = {
      {CameraModel::kPlumbBob, 1280, 800, {640, 642, 648, 393, -0.1, 0.02, 5e-4, -4e-4, 0.001}},
      {CameraModel::kEquidistant, 1280, 960, {380, 381, 645, 474, 0.02, -0.005, 0.001, 1e-4}},
      {CameraModel::kDoubleSphere, 1280, 960, {380, 381, 645, 474, 0.12, 0.58}}};
  for (const CameraIntrinsics& truth : cameras) {
    const auto rays = GridRays(truth, 20, 15, 1.4);
    const CameraIntrinsics fit = FitToRays(StartOf(truth), rays, ParameterCount(truth.model));
    for (std::size_t i = 0; i < truth.parameters.size(); ++i) {
      EXPECT_NEAR(fit.parameters[i], truth.parameters[i], 1e-6 * std::max(1.0, truth.parameters[i]));
    }
  }
}

TEST(FitToRays, HoldsTheParametersBehindTheFreeOnes) {
  const CameraIntrinsics truth{
      CameraModel::kPlumbBob, 1280, 800, {640, 642, 648, 393, -0.1, 0.02, 5e-4, -4e-4, 0.01}};
  CameraIntrinsics start = truth;
  start.parameters[8] = 0.0;
  const auto rays = GridRays(truth, 20, 15, 1.4);
  const CameraIntrinsics fit = FitToRays(start, rays, 8);
  EXPECT_EQ(fit.parameters[8], 0.0);
  // At the minimum no step of a free parameter lowers the squares.
  const double least = SumOfSquares(fit, rays);
  EXPECT_LT(least, SumOfSquares(start, rays));
  for (int i = 0; i < 8; ++i) {
    for (const double step : {-1e-5, 1e-5}) {
      CameraIntrinsics moved = fit;
      moved.parameters[i] += step * (i < 4 ? 100.0 : 1.0);
      EXPECT_GT(SumOfSquares(moved, rays), least) << i;
    }
  }
}

TEST(FitToRays, WithoutRaysTheStartStands) {
  const CameraIntrinsics start = IntrinsicsFromFieldOfView(CameraModel::kEquidistant, 640, 480, 180.0);
  EXPECT_EQ(FitToRays(start, {}, 8).parameters, start.parameters);
}

TEST(GridRays, CoverTheImageUpToTheAngle) {
  const CameraIntrinsics camera = IntrinsicsFromFieldOfView(CameraModel::kEquidistant, 640, 480, 200.0);
  const auto all = GridRays(camera, 11, 7, M_PI);
  ASSERT_EQ(all.size(), 77u);
  EXPECT_EQ(all.front().pixel, Eigen::Vector2d(0.0, 0.0));
  EXPECT_EQ(all.back().pixel, Eigen::Vector2d(639.0, 479.0));
  const auto near_axis = GridRays(camera, 11, 7, 0.5);
  EXPECT_LT(near_axis.size(), all.size());
  EXPECT_FALSE(near_axis.empty());
  for (const PixelRay& ray : near_axis) EXPECT_GT(ray.bearing.z(), std::cos(0.5));
}

}  // namespace
}  // namespace mlic::model_fit_test
