#include "mlic_core/camera/two_view/triangulation.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "mlic_core/common/random.h"
#include "mlic_core/geometry/so3.h"

namespace mlic::triangulation_test {
namespace {

Eigen::Vector3d RandomVector(Random* random) {
  return {random->Normal(), random->Normal(), random->Normal()};
}

// `count` observations of `point` along a path that passes it.
std::vector<BearingObservation> Observations(const Eigen::Vector3d& point, int count, double length,
                                             double noise, Random* random) {
  std::vector<BearingObservation> observations;
  for (int i = 0; i < count; ++i) {
    BearingObservation observation;
    observation.centre =
        Eigen::Vector3d(length * i / std::max(1, count - 1), 0.0, 0.0) + 0.02 * RandomVector(random);
    const Eigen::Vector3d d = (point - observation.centre).normalized();
    observation.direction = ExpMatrix(noise * RandomVector(random)) * d;
    observation.sigma = noise > 0.0 ? noise : 1e-3;
    observations.push_back(observation);
  }
  return observations;
}

TEST(Triangulation, WithoutNoiseThePointComesBack) {
  Random random(1);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3d point(random.Uniform(-5, 10), random.Uniform(3, 40), random.Uniform(-3, 8));
    const auto observations = Observations(point, 2 + i % 8, 4.0, 0.0, &random);
    const auto found = TriangulatePoint(observations);
    ASSERT_TRUE(found) << i;
    EXPECT_LT((found->position - point).norm(), 1e-7) << i;
    EXPECT_EQ(found->inliers, static_cast<int>(observations.size()));
    EXPECT_LT(found->rms, 1e-6);
  }
}

TEST(Triangulation, ErrorsAreAsTheCovarianceSays) {
  Random random(2);
  double sum = 0.0, rms = 0.0;
  const int runs = 1000;
  for (int i = 0; i < runs; ++i) {
    const Eigen::Vector3d point(random.Uniform(-5, 10), random.Uniform(5, 20), random.Uniform(-3, 8));
    TriangulationOptions options;
    options.largest_error = 10.0;
    const auto found = TriangulatePoint(Observations(point, 6, 4.0, 5e-4, &random), options);
    ASSERT_TRUE(found);
    const Eigen::Vector3d error = found->position - point;
    sum += error.dot(found->covariance.llt().solve(error));
    rms += found->rms * found->rms;
  }
  EXPECT_NEAR(sum / runs, 3.0, 0.25);  // chi-squared, 3 degrees of freedom: 4.5 sigmas of its mean
  EXPECT_NEAR(rms / runs, 1.0, 0.07);
}

TEST(Triangulation, OneOrTwoOutliersAreDropped) {
  Random random(3);
  int right = 0;
  const int runs = 200;
  for (int i = 0; i < runs; ++i) {
    const Eigen::Vector3d point(random.Uniform(-5, 10), random.Uniform(5, 20), random.Uniform(-3, 8));
    auto observations = Observations(point, 7, 4.0, 5e-4, &random);
    const std::size_t bad = i % 7, second = (i * 3 + 1) % 7;
    observations[bad].direction = ExpMatrix(random.Uniform(0.02, 0.5) * RandomVector(&random).normalized()) *
                                  observations[bad].direction;
    observations[second].direction =
        ExpMatrix(0.05 * RandomVector(&random).normalized()) * observations[second].direction;
    const auto found = TriangulatePoint(observations);
    if (!found) continue;
    const Eigen::Vector3d error = found->position - point;
    right += !found->inlier[bad] && !found->inlier[second] &&
             error.dot(found->covariance.llt().solve(error)) < 16.0;
  }
  EXPECT_GT(right, 0.9 * runs);
}

TEST(Triangulation, TwoOfThreeProveNothing) {
  Random random(4);
  auto observations = Observations({2.0, 10.0, 1.0}, 3, 4.0, 0.0, &random);
  observations[1].direction = ExpMatrix(Eigen::Vector3d(0.1, 0.0, 0.05)) * observations[1].direction;
  EXPECT_FALSE(TriangulatePoint(observations));
}

TEST(Triangulation, SmallParallaxGivesNothing) {
  Random random(5);
  EXPECT_FALSE(TriangulatePoint(Observations({2.0, 1000.0, 1.0}, 5, 4.0, 0.0, &random)));
  TriangulationOptions options;
  options.least_parallax_deg = 0.1;
  const auto found = TriangulatePoint(Observations({2.0, 1000.0, 1.0}, 5, 4.0, 0.0, &random), options);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->parallax, 4.0 / 1000.0, 2e-4);
  options.farthest = 500.0;
  EXPECT_FALSE(TriangulatePoint(Observations({2.0, 1000.0, 1.0}, 5, 4.0, 0.0, &random), options));
}

TEST(Triangulation, RaysThatMeetBehindGiveNothing) {
  Random random(6);
  auto observations = Observations({2.0, 10.0, 1.0}, 5, 4.0, 0.0, &random);
  for (BearingObservation& observation : observations) observation.direction *= -1.0;
  EXPECT_FALSE(TriangulatePoint(observations));
}

TEST(Triangulation, ParallelRaysAndOneObservationGiveNothing) {
  BearingObservation observation;
  observation.centre.setZero();
  observation.direction = Eigen::Vector3d::UnitY();
  EXPECT_FALSE(TriangulatePoint({observation}));
  EXPECT_FALSE(TriangulatePoint({observation, observation, observation}));
  BearingObservation beside = observation;
  beside.centre.x() = 1.0;
  EXPECT_FALSE(TriangulatePoint({observation, beside}));
}

// A moved and turned frame moves and turns the result.
TEST(Triangulation, DoesNotDependOnTheFrame) {
  Random random(7);
  auto observations = Observations({2.0, 10.0, 1.0}, 5, 4.0, 1e-3, &random);
  const auto before = TriangulatePoint(observations);
  const Eigen::Matrix3d R = ExpMatrix({0.4, -1.0, 2.0});
  const Eigen::Vector3d t(100.0, -50.0, 7.0);
  for (BearingObservation& observation : observations) {
    observation.centre = R * observation.centre + t;
    observation.direction = R * observation.direction;
  }
  const auto after = TriangulatePoint(observations);
  ASSERT_TRUE(before && after);
  EXPECT_LT((after->position - (R * before->position + t)).norm(), 1e-6);
  EXPECT_LT((after->covariance - R * before->covariance * R.transpose()).norm(),
            1e-6 * before->covariance.norm());
}

}  // namespace
}  // namespace mlic::triangulation_test
