#include "mlic_core/uncertainty/point_scatter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "mlic_core/common/random.h"
#include "mlic_core/problem/joint_solver.h"
#include "mlic_core/problem/layout.h"
#include "support/lidars_at_rest.h"

namespace mlic::point_scatter_test {
namespace {

constexpr int kSeconds = 40;
constexpr int kPointsOfSecond = 50;  // of one LiDAR on one plane
constexpr double kSigma = 0.01;      // m

// Two LiDARs that stand still before three planes at right angles. On the level one, the points of a LiDAR
// and second share an error with `correlation` of the variance; on the others errors are white.
class TwoLidars : public testing::Test {
 protected:
  TwoLidars() { PlaceAtRest(kSeconds, 2, &dataset_, &problem_, &state_); }

  void AddPlane(int axis, double correlation) {
    PlaneAssociation& planes = problem_.drives[0].planes;
    MapPlane plane;
    plane.plane = {-Eigen::Vector3d::Unit(axis), -5.0};
    plane.center = 5.0 * Eigen::Vector3d::Unit(axis);
    planes.planes.push_back(plane);
    for (int lidar = 0; lidar < 2; ++lidar) {
      for (int second = 0; second < kSeconds; ++second) {
        const double shared = std::sqrt(correlation) * random_.Normal();
        for (int k = 0; k < kPointsOfSecond; ++k) {
          Eigen::Vector3d point;
          point[axis] = 5.0;
          point[(axis + 1) % 3] = random_.Uniform(-1.0, 1.0);
          point[(axis + 2) % 3] = random_.Uniform(-1.0, 1.0);
          const double error = shared + std::sqrt(1.0 - correlation) * random_.Normal();
          point *= 1.0 + kSigma * error / point.norm();
          planes.observations.push_back({point.cast<float>(), static_cast<float>(kSigma), 1.0f, 0.0f, lidar,
                                         0, second + 0.9 * k / kPointsOfSecond});
        }
      }
    }
    planes.begin.push_back(planes.observations.size());
  }

  // By how much the scatter exceeds that of white errors where one LiDAR is moved against the other.
  double ExcessAlong(int axis, const Eigen::MatrixXd& scatter) const {
    Eigen::VectorXd move = Eigen::VectorXd::Zero(scatter.rows());
    move[Layout::Lidar(0) + 3 + axis] = 0.5;
    move[Layout::Lidar(1) + 3 + axis] = -0.5;
    // Each LiDAR half of a metre to the plane: a quarter of all points' information.
    return move.dot(scatter * move) * kSigma * kSigma / (0.25 * 2 * kSeconds * kPointsOfSecond);
  }

  Random random_{5};
  Dataset dataset_;
  JointProblem problem_;
  CalibrationState state_;
};

TEST_F(TwoLidars, ScatterGrowsAlongWhatTheRoughPlaneShows) {
  constexpr double kCorrelation = 0.1;
  AddPlane(0, 0.0);
  AddPlane(1, 0.0);
  AddPlane(2, kCorrelation);
  SolveJointProblem(problem_, 3, CancellationToken(), &state_);
  const Eigen::MatrixXd scatter = ScatterOfPoints({problem_, state_}, 1.0);
  // Half of it where the trajectory follows what both LiDARs' errors have in common.
  EXPECT_GT(ExcessAlong(2, scatter), 0.35 * kCorrelation * (kPointsOfSecond - 1));
  EXPECT_LT(ExcessAlong(2, scatter), 1.35 * kCorrelation * (kPointsOfSecond - 1));
  EXPECT_LT(ExcessAlong(0, scatter), 0.5);
  EXPECT_LT(ExcessAlong(1, scatter), 0.5);
  // What is usual counts elsewhere.
  EXPECT_LT(ScatterOfPoints({problem_, state_}, 100.0).norm(), 1e-9 * scatter.norm());
}

// One LiDAR's rings were corrected, but not in what their ranges err by together, unless that is found.
TEST_F(TwoLidars, MeanRangeOfTheRingsStaysUnknown) {
  constexpr int kRings = 64;
  constexpr double kTypical = 0.03;  // m
  constexpr double kUsual = 100.0;
  for (int axis = 0; axis < 3; ++axis) AddPlane(axis, 0.0);
  std::vector<PlaneObservation>& points = problem_.drives[0].planes.observations;
  for (std::size_t k = 0; k < points.size(); ++k) points[k].ring = k % kRings;
  SolveJointProblem(problem_, 3, CancellationToken(), &state_);
  state_.rings.resize(2);
  for (int ring = 0; ring < kRings; ++ring) {
    state_.rings[0].push_back({static_cast<float>(kTypical * random_.Normal()), 0.0f});
  }
  const Eigen::MatrixXd scatter = ScatterOfPoints({problem_, state_}, kUsual);
  // The mean's variance is kTypical^2 / kRings; as information (ExcessAlong), beside the points' own.
  const double points_of_lidar = kSeconds * kPointsOfSecond;
  const double expected = kTypical * kTypical / kRings * points_of_lidar / (2.0 * kSigma * kSigma) / kUsual;
  for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(ExcessAlong(axis, scatter) / expected, 1.0, 0.5);
  state_.ranges.resize(2);
  state_.ranges[0].offset = 1e-3;
  const Eigen::MatrixXd found = ScatterOfPoints({problem_, state_}, kUsual);
  for (int axis = 0; axis < 3; ++axis) EXPECT_LT(ExcessAlong(axis, found), 0.3 * ExcessAlong(axis, scatter));
}

}  // namespace
}  // namespace mlic::point_scatter_test
