#include "mlic_core/camera/two_view/two_view.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "mlic_core/camera/two_view/five_point.h"
#include "mlic_core/common/random.h"
#include "mlic_core/geometry/so3.h"

namespace mlic::two_view_test {
namespace {

Eigen::Vector3d RandomVector(Random* random) {
  return {random->Normal(), random->Normal(), random->Normal()};
}

struct Scene {
  Eigen::Matrix3d R_b_a;
  Eigen::Vector3d t_b_a;  // m
  std::vector<Eigen::Vector3d> a, b;
  std::vector<bool> good;
};

struct SceneOptions {
  int matches = 300;
  double half_fov = 0.6;  // rad
  double noise = 0.0;     // rad, of each bearing
  double outliers = 0.0;  // share
  double baseline = 1.0;  // m
  double turn = 0.2;      // rad
};

// Points at 4 to 30 m, seen by both views within half_fov of their z axes.
Scene MakeScene(std::uint64_t seed, const SceneOptions& options) {
  Random random(seed);
  Scene scene;
  scene.R_b_a = ExpMatrix(options.turn * RandomVector(&random).normalized());
  scene.t_b_a = options.baseline * RandomVector(&random).normalized();
  const auto noisy = [&](const Eigen::Vector3d& bearing) -> Eigen::Vector3d {
    return ExpMatrix(options.noise * RandomVector(&random)) * bearing;
  };
  const auto anywhere = [&] {
    const double cosine = random.Uniform(std::cos(options.half_fov), 1.0),
                 phi = random.Uniform(0.0, 2.0 * M_PI);
    const double sine = std::sqrt(1.0 - cosine * cosine);
    return Eigen::Vector3d(sine * std::cos(phi), sine * std::sin(phi), cosine);
  };
  while (static_cast<int>(scene.a.size()) < options.matches) {
    const Eigen::Vector3d point = random.Uniform(4.0, 30.0) * anywhere();
    const Eigen::Vector3d in_b = scene.R_b_a * point + scene.t_b_a;
    if (std::atan2(in_b.head<2>().norm(), in_b.z()) > options.half_fov) continue;
    const bool good = random.Uniform() >= options.outliers;
    scene.a.push_back(noisy(point.normalized()));
    scene.b.push_back(good ? noisy(in_b.normalized()) : anywhere());
    scene.good.push_back(good);
  }
  return scene;
}

double RotationError(const Eigen::Matrix3d& R, const Scene& scene) {
  return Log(Eigen::Matrix3d(R.transpose() * scene.R_b_a)).norm();
}

double DirectionError(const Eigen::Vector3d& t, const Scene& scene) {
  return std::atan2(t.cross(scene.t_b_a).norm(), t.dot(scene.t_b_a));
}

TEST(FivePoint, FindsTheTrueEssentialMatrix) {
  int found = 0;
  for (int seed = 0; seed < 100; ++seed) {
    SceneOptions options;
    options.matches = 5;
    options.half_fov = 1.6;
    const Scene scene = MakeScene(seed, options);
    Eigen::Vector3d a[5], b[5];
    std::copy(scene.a.begin(), scene.a.end(), a);
    std::copy(scene.b.begin(), scene.b.end(), b);
    Eigen::Matrix3d solutions[kMostEssentialMatrices];
    const int count = SolveFivePoint(a, b, solutions);
    const Eigen::Matrix3d truth = Hat(scene.t_b_a.normalized()) * scene.R_b_a;
    double nearest = 1.0;
    for (int s = 0; s < count; ++s) {
      nearest = std::min({nearest, (solutions[s] - truth).norm(), (solutions[s] + truth).norm()});
      for (int i = 0; i < 5; ++i) EXPECT_NEAR(b[i].dot(solutions[s] * a[i]), 0.0, 1e-9);
    }
    found += nearest < 1e-5;
  }
  EXPECT_GE(found, 97);
}

TEST(TwoView, WithoutNoiseTheTruthComesBack) {
  for (int seed = 0; seed < 20; ++seed) {
    const Scene scene = MakeScene(seed, {});
    const auto geometry = EstimateTwoView(scene.a, scene.b, {});
    ASSERT_TRUE(geometry);
    EXPECT_TRUE(geometry->has_translation);
    EXPECT_EQ(geometry->inliers, 300);
    EXPECT_LT(RotationError(geometry->R_b_a, scene), 1e-8);
    EXPECT_LT(DirectionError(geometry->t_b_a, scene), 1e-7);
    EXPECT_NEAR(geometry->t_b_a.norm(), 1.0, 1e-12);
  }
}

TEST(TwoView, OutliersAreLeftOut) {
  for (int seed = 0; seed < 10; ++seed) {
    SceneOptions options;
    options.noise = 0.001;
    options.outliers = 0.4;
    const Scene scene = MakeScene(seed, options);
    const auto geometry = EstimateTwoView(scene.a, scene.b, {});
    ASSERT_TRUE(geometry);
    EXPECT_TRUE(geometry->has_translation);
    EXPECT_LT(RotationError(geometry->R_b_a, scene), 0.004) << seed;
    EXPECT_LT(DirectionError(geometry->t_b_a, scene), 0.06) << seed;
    int lost = 0, wrong = 0, good = 0;
    for (std::size_t i = 0; i < scene.good.size(); ++i) {
      good += scene.good[i];
      lost += scene.good[i] && !geometry->inlier[i];
      wrong += !scene.good[i] && geometry->inlier[i];
    }
    EXPECT_LT(lost, 0.03 * good) << seed;
    EXPECT_LT(wrong, 0.08 * (300 - good)) << seed;
    EXPECT_EQ(std::count(geometry->inlier.begin(), geometry->inlier.end(), true), geometry->inliers);
  }
}

// 190 degrees: a good part of the bearings lies on or behind the plane z = 0.
TEST(TwoView, FisheyesSeeBehindTheImagePlane) {
  for (int seed = 0; seed < 10; ++seed) {
    SceneOptions options;
    options.half_fov = 95.0 * M_PI / 180.0;
    options.noise = 0.001;
    options.outliers = 0.3;
    options.turn = 1.0;
    const Scene scene = MakeScene(seed, options);
    const auto geometry = EstimateTwoView(scene.a, scene.b, {});
    ASSERT_TRUE(geometry);
    EXPECT_LT(RotationError(geometry->R_b_a, scene), 0.002) << seed;
    EXPECT_LT(DirectionError(geometry->t_b_a, scene), 0.02) << seed;
  }
}

TEST(TwoView, RotationAloneShowsNoTranslation) {
  for (const double baseline : {0.0, 0.003}) {
    for (int seed = 0; seed < 10; ++seed) {
      SceneOptions options;
      options.noise = 0.001;
      options.outliers = 0.3;
      options.baseline = baseline;
      const Scene scene = MakeScene(seed, options);
      const auto geometry = EstimateTwoView(scene.a, scene.b, {});
      ASSERT_TRUE(geometry);
      EXPECT_FALSE(geometry->has_translation);
      EXPECT_EQ(geometry->t_b_a.norm(), 0.0);
      EXPECT_LT(RotationError(geometry->R_b_a, scene), 0.0006) << seed;
      EXPECT_GT(geometry->inliers, 180);
    }
  }
}

// A few near points among many far ones show the translation, and are not lost to a rotation.
TEST(TwoView, FewNearPointsShowTheTranslation) {
  for (int seed = 0; seed < 10; ++seed) {
    SceneOptions options;
    options.noise = 0.0005;
    options.baseline = 0.05;
    options.matches = 270;
    const Scene far = MakeScene(seed, options);
    options.baseline = 1.0;
    options.matches = 30;
    Scene scene = MakeScene(seed, options);  // the same motion, 20 times as near
    scene.a.insert(scene.a.end(), far.a.begin(), far.a.end());
    scene.b.insert(scene.b.end(), far.b.begin(), far.b.end());
    const auto geometry = EstimateTwoView(scene.a, scene.b, {});
    ASSERT_TRUE(geometry);
    EXPECT_TRUE(geometry->has_translation) << seed;
    EXPECT_GT(geometry->inliers, 290) << seed;
    EXPECT_LT(DirectionError(geometry->t_b_a, scene), 0.1) << seed;
  }
}

TEST(TwoView, SwappedViewsInvertTheResult) {
  SceneOptions options;
  options.noise = 0.0005;
  const Scene scene = MakeScene(4, options);
  const auto forward = EstimateTwoView(scene.a, scene.b, {});
  const auto backward = EstimateTwoView(scene.b, scene.a, {});
  ASSERT_TRUE(forward && backward);
  EXPECT_LT((forward->R_b_a * backward->R_b_a - Eigen::Matrix3d::Identity()).norm(), 1e-4);
  EXPECT_LT((forward->R_b_a * backward->t_b_a + forward->t_b_a).norm(), 1e-3);
}

TEST(TwoView, ErrorsShrinkWithNoise) {
  double error[2] = {0.0, 0.0};
  for (int level = 0; level < 2; ++level) {
    for (int seed = 0; seed < 10; ++seed) {
      SceneOptions options;
      options.noise = level == 0 ? 1e-3 : 1e-5;
      const Scene scene = MakeScene(seed, options);
      const auto geometry = EstimateTwoView(scene.a, scene.b, {});
      ASSERT_TRUE(geometry);
      error[level] += RotationError(geometry->R_b_a, scene);
    }
  }
  EXPECT_LT(error[1], 0.02 * error[0]);
}

TEST(TwoView, SameSeedSameResult) {
  SceneOptions options;
  options.noise = 0.001;
  options.outliers = 0.4;
  const Scene scene = MakeScene(3, options);
  const auto first = EstimateTwoView(scene.a, scene.b, {}), second = EstimateTwoView(scene.a, scene.b, {});
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->R_b_a, second->R_b_a);
  EXPECT_EQ(first->inlier, second->inlier);
}

TEST(TwoView, NothingAgreesInNoise) {
  SceneOptions options;
  options.outliers = 1.0;
  options.matches = 200;
  const Scene scene = MakeScene(5, options);
  TwoViewOptions strict;
  strict.fewest_inliers = 30;
  EXPECT_FALSE(EstimateTwoView(scene.a, scene.b, strict));
}

TEST(TwoView, TooFewMatchesGiveNothing) {
  const std::vector<Eigen::Vector3d> one(4, Eigen::Vector3d::UnitZ());
  EXPECT_FALSE(EstimateTwoView(one, one, {}));
  EXPECT_FALSE(EstimateTwoView({}, {}, {}));
  // All the same point: no frame, no epipolar geometry, no crash.
  const std::vector<Eigen::Vector3d> same(40, Eigen::Vector3d::UnitZ());
  const auto geometry = EstimateTwoView(same, same, {});
  EXPECT_TRUE(!geometry || geometry->R_b_a.allFinite());
}

TEST(EpipolarError, IsTheAngleToTheNearestPair) {
  const Scene scene = MakeScene(6, {});
  const Eigen::Vector3d t = scene.t_b_a.normalized();
  for (int i = 0; i < 20; ++i) {
    EXPECT_NEAR(EpipolarError(scene.R_b_a, t, scene.a[i], scene.b[i]), 0.0, 1e-14);
    // Turned off its epipolar plane by an angle, half of it could be made up in either view.
    const Eigen::Vector3d q = scene.R_b_a * scene.a[i];
    const Eigen::Vector3d normal = t.cross(q).normalized();
    const Eigen::Vector3d turned = (scene.b[i] + 1e-4 * normal).normalized();
    const double error = std::abs(EpipolarError(scene.R_b_a, t, scene.a[i], turned));
    EXPECT_LT(error, 1e-4);
    EXPECT_GT(error, 0.4e-4);
  }
}

}  // namespace
}  // namespace mlic::two_view_test
