#include "mlic_core/association/group_errors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "mlic_core/common/random.h"
#include "mlic_core/problem/joint_solver.h"

namespace mlic::group_errors_test {
namespace {

constexpr double kSigma = 0.01;  // m
constexpr int kSeconds = 200;    // every other one; so many that a plane hardly follows one of them

// Points of a LiDAR that stands still, on planes that the solve has fitted to them. Those of one plane and
// second share an error with `correlation` of the variance.
class SharedErrors {
 public:
  explicit SharedErrors(std::uint64_t seed) : random_(seed) {
    const UniformKnots knots = UniformKnots::Covering(-1.0, 2.0 * kSeconds + 1.0, 1.0);
    DriveState drive;
    drive.trajectory.rotation =
        So3Spline(knots, std::vector<Eigen::Quaterniond>(knots.count, Eigen::Quaterniond::Identity()));
    drive.trajectory.position =
        PositionSpline(knots, std::vector<Eigen::Vector3d>(knots.count, Eigen::Vector3d::Zero()));
    state_.drives = {drive};
    state_.lidars.resize(1);
    planes_.begin = {0};
  }

  // Sizes of the groups of each second: log-uniform from 5 to 300.
  void AddPlane(int seconds, double correlation) {
    MapPlane plane;
    plane.plane = {-Eigen::Vector3d::UnitX(), -10.0};  // to the LiDAR
    plane.center = {10.0, 0.0, 0.0};
    planes_.planes.push_back(plane);
    for (int second = 0; second < seconds; ++second) {
      const int count = static_cast<int>(std::lround(5.0 * std::pow(60.0, random_.Uniform(0.0, 1.0))));
      const double shared = std::sqrt(correlation) * random_.Normal();
      for (int k = 0; k < count; ++k) {
        Eigen::Vector3d point(10.0, random_.Uniform(-1.0, 1.0), random_.Uniform(-1.0, 1.0));
        const double error = shared + std::sqrt(1.0 - correlation) * random_.Normal();
        point *= 1.0 + kSigma * error / point.norm();
        planes_.observations.push_back({point.cast<float>(), static_cast<float>(kSigma), 1.0f, 0.0f, 0, 0,
                                        2.0 * second + 0.9 * k / count});
      }
      points_ += count;
      squared_sizes_ += static_cast<double>(count) * count;
    }
    planes_.begin.push_back(planes_.observations.size());
  }

  double Factor() { return CorrelationFactor(Solved().drives, state_); }

  PlaneNoise Noise() {
    std::vector<PlaneNoise> noise(1);
    MeasureSharedErrors(Solved().drives, state_, &noise);
    return noise[0];
  }

  // Each group counts for what it is worth.
  void Weigh(const PlaneNoise& noise) {
    for (std::size_t p = 0; p < planes_.planes.size(); ++p) WeighGroups({noise}, p, &planes_);
  }

  // Of the variance of a mean over all points.
  double Expected(double correlation) const { return 1.0 + correlation * (squared_sizes_ / points_ - 1.0); }

 private:
  JointProblem Solved() {
    JointProblem problem;
    problem.dataset = &dataset_;
    problem.drives.resize(1);
    problem.drives[0].planes = planes_;
    problem.lidars = {{std::nullopt, true}};
    problem.fix_trajectory = true;
    SolveSummary summary = SolveJointProblem(problem, 3, CancellationToken(), &state_);
    PlaceLandmarks(std::move(summary.landmarks), &problem);
    return problem;
  }

  Random random_;
  Dataset dataset_{std::vector<Drive>(1)};
  CalibrationState state_;
  PlaneAssociation planes_;
  double points_ = 0.0, squared_sizes_ = 0.0;
};

TEST(CorrelationFactor, IsOneForWhiteErrorsAlsoWhereAPlaneIsSeenOnce) {
  SharedErrors errors(1);
  for (int p = 0; p < 10; ++p) errors.AddPlane(p % 2 == 0 ? 1 : kSeconds, 0.0);
  EXPECT_NEAR(errors.Factor(), 1.0, 0.15);
}

TEST(CorrelationFactor, IsWhatTheVarianceGrowsByForGroupsOfAllSizes) {
  for (const double correlation : {0.02, 0.05, 0.1}) {
    SharedErrors errors(2);
    for (int p = 0; p < 10; ++p) errors.AddPlane(kSeconds, correlation);
    EXPECT_NEAR(errors.Factor() / errors.Expected(correlation), 1.0, 0.2) << correlation;
  }
}

// A plane that is seen for one second has followed its common error: it neither shows it nor hides that of
// the others.
TEST(CorrelationFactor, IsNotHiddenByPlanesThatAreSeenOnce) {
  SharedErrors errors(3);
  for (int p = 0; p < 8; ++p) errors.AddPlane(kSeconds, 0.05);
  const double expected = errors.Expected(0.05);
  for (int p = 0; p < 1200; ++p) errors.AddPlane(1, 0.05);
  EXPECT_NEAR(errors.Factor() / expected, 1.0, 0.25);
}

TEST(SharedErrors, AreNoneOfWhiteResiduals) {
  SharedErrors errors(4);
  for (int p = 0; p < 10; ++p) errors.AddPlane(kSeconds, 0.0);
  EXPECT_NEAR(GrowthOf(errors.Noise(), 300.0), 1.0, 0.2);
}

// Weights that have what groups share leave nothing, and do not hide it.
TEST(SharedErrors, AreMeasuredAndTakenIntoWeights) {
  for (const double correlation : {0.02, 0.05, 0.1}) {
    SharedErrors errors(5);
    for (int p = 0; p < 10; ++p) errors.AddPlane(kSeconds, correlation);
    const PlaneNoise noise = errors.Noise();
    for (const double points : {8.0, 32.0, 128.0}) {
      EXPECT_NEAR(GrowthOf(noise, points) / (1.0 + correlation * points), 1.0, 0.25) << points;
    }
    errors.Weigh(noise);
    EXPECT_NEAR(errors.Factor(), 1.0, 0.15) << correlation;
    EXPECT_NEAR(GrowthOf(errors.Noise(), 128.0) / GrowthOf(noise, 128.0), 1.0, 0.1);
  }
}

}  // namespace
}  // namespace mlic::group_errors_test
