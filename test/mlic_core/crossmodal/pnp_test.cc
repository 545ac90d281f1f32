#include "mlic_core/crossmodal/pnp.h"

#include <gtest/gtest.h>

#include "mlic_core/common/random.h"
#include "mlic_core/crossmodal/three_point.h"
#include "mlic_core/geometry/so3.h"

namespace mlic::pnp_test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

Vector3d RandomVector(Random* random) { return {random->Normal(), random->Normal(), random->Normal()}; }

RigidTransform RandomPose(Random* random) {
  return {ExpQuaternion(2.0 * RandomVector(random)), RandomVector(random)};
}

double PoseError(const RigidTransform& a, const RigidTransform& b) {
  return AngleBetween(a.rotation, b.rotation) + (a.translation - b.translation).norm();
}

// A scene before a camera: correspondences with noise of `sigma` px, the first `outliers` of them anywhere.
struct Scene {
  CameraIntrinsics intrinsics;
  RigidTransform T_camera_body;
  std::vector<PointCorrespondence> correspondences;
};

Scene MakeScene(CameraModel model, double fov_deg, int count, double outlier_share, double sigma,
                std::uint64_t seed) {
  Random random(seed);
  Scene scene;
  scene.intrinsics = IntrinsicsFromFieldOfView(model, 1280, 960, fov_deg);
  scene.T_camera_body = RandomPose(&random);
  while (static_cast<int>(scene.correspondences.size()) < count) {
    const Vector2d pixel(random.Uniform(0, 1279), random.Uniform(0, 959));
    Vector3d bearing;
    if (!Unproject(scene.intrinsics, pixel, &bearing)) continue;
    PointCorrespondence correspondence;
    correspondence.point = scene.T_camera_body.Inverse() * (random.Uniform(2, 30) * bearing);
    const bool outlier = scene.correspondences.size() < outlier_share * count;
    // Half of the correspondences are four times as precise along x.
    const Vector2d sigmas(scene.correspondences.size() % 2 == 0 ? 0.25 * sigma : sigma, sigma);
    correspondence.pixel = pixel + sigmas.cwiseProduct(Vector2d(random.Normal(), random.Normal()));
    if (outlier) correspondence.pixel = {random.Uniform(0, 1279), random.Uniform(0, 959)};
    correspondence.covariance = sigmas.cwiseAbs2().asDiagonal();
    scene.correspondences.push_back(correspondence);
  }
  return scene;
}

TEST(ThreePoint, FindsThePoseAtAnyAngleFromTheAxis) {
  Random random(3);
  int found = 0;
  for (int i = 0; i < 2000; ++i) {
    const RigidTransform T = RandomPose(&random);
    Vector3d points[3], bearings[3];
    for (int k = 0; k < 3; ++k) {
      bearings[k] = RandomVector(&random).normalized();
      points[k] = T.Inverse() * (random.Uniform(1, 20) * bearings[k]);
    }
    RigidTransform poses[kMostThreePointPoses];
    const int count = SolveThreePoint(bearings, points, poses);
    for (int k = 0; k < count; ++k) {
      // Every solution sees the points along the bearings.
      for (int j = 0; j < 3; ++j) {
        EXPECT_LT(((poses[k] * points[j]).normalized() - bearings[j]).norm(), 1e-6);
      }
      if (PoseError(poses[k], T) < 1e-6) {
        ++found;
        break;
      }
    }
  }
  EXPECT_GE(found, 1998);
}

TEST(ThreePoint, RefusesPointsOnALine) {
  const Vector3d points[3] = {{0, 0, 1}, {0, 0, 2}, {0, 0, 3}};
  const Vector3d bearings[3] = {
      {0, 0, 1}, Vector3d(0.1, 0, 1).normalized(), Vector3d(0, 0.1, 1).normalized()};
  RigidTransform poses[kMostThreePointPoses];
  EXPECT_EQ(SolveThreePoint(bearings, points, poses), 0);
}

TEST(Pnp, ExactCorrespondencesGiveTheExactPose) {
  for (const CameraModel model : {CameraModel::kPlumbBob, CameraModel::kEquidistant}) {
    const Scene scene = MakeScene(model, model == CameraModel::kPlumbBob ? 100 : 190, 60, 0.0, 0.0, 5);
    const auto result = EstimatePose(scene.correspondences, scene.intrinsics, {});
    ASSERT_TRUE(result);
    EXPECT_EQ(result->inliers, 60);
    EXPECT_LT(PoseError(result->T_camera_body, scene.T_camera_body), 1e-7);
  }
}

TEST(Pnp, WithstandsHalfOutliersOnAFisheye) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Scene scene = MakeScene(CameraModel::kEquidistant, 190, 200, 0.5, 0.5, seed);
    const auto result = EstimatePose(scene.correspondences, scene.intrinsics, {});
    ASSERT_TRUE(result) << seed;
    EXPECT_LT(PoseError(result->T_camera_body, scene.T_camera_body), 0.01) << seed;
    int false_inliers = 0, true_inliers = 0;
    for (int i = 0; i < 200; ++i) (i < 100 ? false_inliers : true_inliers) += result->inlier[i];
    EXPECT_LE(false_inliers, 2) << seed;
    EXPECT_GE(true_inliers, 96) << seed;
  }
}

TEST(Pnp, ErrorsAreAsTheCovarianceSays) {
  double sum = 0.0;
  constexpr int kRuns = 100;
  PnpOptions options;
  options.model_sigma = 0.0;
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    const Scene scene = MakeScene(CameraModel::kEquidistant, 150, 100, 0.2, 0.7, seed);
    const auto result = EstimatePose(scene.correspondences, scene.intrinsics, options);
    ASSERT_TRUE(result);
    Eigen::Matrix<double, 6, 1> error;
    error.head<3>() = Log(scene.T_camera_body.rotation * result->T_camera_body.rotation.conjugate());
    error.tail<3>() = scene.T_camera_body.translation - result->T_camera_body.translation;
    sum += error.dot(result->covariance.ldlt().solve(error));
  }
  // Six degrees of freedom; the mean of 100 draws has a standard deviation of 0.35.
  EXPECT_NEAR(sum / kRuns, 6.0, 1.5);
}

TEST(Pnp, ReportsWhenNothingAgrees) {
  const Scene scene = MakeScene(CameraModel::kPlumbBob, 100, 100, 1.0, 0.5, 9);
  EXPECT_FALSE(EstimatePose(scene.correspondences, scene.intrinsics, {}));
  EXPECT_FALSE(EstimatePose({}, scene.intrinsics, {}));
}

TEST(Pnp, SameInputSameOutput) {
  const Scene scene = MakeScene(CameraModel::kEquidistant, 190, 200, 0.5, 0.5, 4);
  const auto a = EstimatePose(scene.correspondences, scene.intrinsics, {});
  const auto b = EstimatePose(scene.correspondences, scene.intrinsics, {});
  ASSERT_TRUE(a && b);
  EXPECT_EQ(a->T_camera_body.translation, b->T_camera_body.translation);
  EXPECT_EQ(a->inlier, b->inlier);
}

}  // namespace
}  // namespace mlic::pnp_test
