#include "mlic_core/summary/sigmas_in_use.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "mlic_core/common/order_statistics.h"
#include "mlic_core/common/random.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/problem/layout.h"
#include "mlic_core/sensors/camera_model.h"

namespace mlic::sigmas_in_use_test {
namespace {

constexpr int kDraws = 4000;  // sigmas are good to 1.1 percent

const CameraIntrinsics kLeft{CameraModel::kPlumbBob,
                             752,
                             480,
                             {392.8, 392.1, 371.4, 243.9, -0.0914, 0.0183, 0.0004, -0.0006, -0.0011}};
const CameraIntrinsics kRight{
    CameraModel::kEquidistant, 752, 480, {310.6, 311.2, 379.7, 237.2, -0.0187, 0.0011, -0.0003, 0.0001}};

// From the optical frame of one that looks ahead to x forward, z up.
const Eigen::Quaterniond kLooksAhead = FromRollPitchYaw({-0.5 * M_PI, 0.0, -0.5 * M_PI});

// Parameters with these sigmas and random correlations, strong ones among them.
Eigen::MatrixXd RandomCovariance(Random& random, const Eigen::VectorXd& sigmas) {
  const Eigen::Index size = sigmas.size();
  Eigen::MatrixXd mix(size, size);
  for (Eigen::Index i = 0; i < mix.size(); ++i) mix.data()[i] = random.Normal();
  mix += 2.0 * mix.col(0) * Eigen::RowVectorXd::Ones(size) / std::sqrt(static_cast<double>(size));
  Eigen::MatrixXd covariance = mix * mix.transpose();
  const Eigen::VectorXd scale = sigmas.cwiseQuotient(covariance.diagonal().cwiseSqrt());
  return scale.asDiagonal() * covariance * scale.asDiagonal();
}

Eigen::VectorXd PoseSigmas(std::size_t intrinsics_of_a, std::size_t intrinsics_of_b) {
  Eigen::VectorXd sigmas(6 + intrinsics_of_a + intrinsics_of_b);
  sigmas << 8e-4, 6e-4, 9e-4, 4e-3, 6e-3, 5e-3,
      Eigen::VectorXd::Constant(static_cast<Eigen::Index>(intrinsics_of_a + intrinsics_of_b), 2e-4);
  for (Eigen::Index i = 0; i < 4; ++i) {
    if (intrinsics_of_a > 0) sigmas[6 + i] = 0.2;
    if (intrinsics_of_b > 0) sigmas[6 + static_cast<Eigen::Index>(intrinsics_of_a) + i] = 0.3;
  }
  return sigmas;
}

CameraIntrinsics Moved(CameraIntrinsics camera, const Eigen::VectorXd& step) {
  for (Eigen::Index i = 0; i < step.size(); ++i) camera.parameters[static_cast<std::size_t>(i)] += step[i];
  return camera;
}

RigidTransform Moved(const RigidTransform& T, const Eigen::VectorXd& step) {
  return {ExpQuaternion(step.head<3>()) * T.rotation, T.translation + step.segment<3>(3)};
}

// Sums of squares of errors that were drawn.
template <int kSize>
struct Scatter {
  Eigen::Matrix<double, kSize, kSize> sum = Eigen::Matrix<double, kSize, kSize>::Zero();
  int count = 0;

  void Add(const Eigen::Matrix<double, kSize, 1>& error) {
    sum += error * error.transpose();
    ++count;
  }
  double LargestSigma() const {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, kSize, kSize>> eigen(sum / count);
    return std::sqrt(eigen.eigenvalues()[kSize - 1]);
  }
};

// The steps of the parameters that a covariance allows, drawn.
std::vector<Eigen::VectorXd> Draw(Random& random, const Eigen::MatrixXd& covariance) {
  const Eigen::MatrixXd root = Eigen::LLT<Eigen::MatrixXd>(covariance).matrixL();
  std::vector<Eigen::VectorXd> steps;
  for (int k = 0; k < kDraws; ++k) {
    Eigen::VectorXd normal(covariance.rows());
    for (Eigen::Index i = 0; i < normal.size(); ++i) normal[i] = random.Normal();
    steps.push_back(root * normal);
  }
  return steps;
}

// Pixels of b that see points at this distance, of which a camera a sees all.
std::vector<Eigen::Vector2d> SeenPixels(const UncertainPose& pose, double distance) {
  std::vector<Eigen::Vector2d> seen;
  for (int row = 0; row < 10; ++row) {
    for (int column = 0; column < 16; ++column) {
      const Eigen::Vector2d pixel((column + 0.5) * 47.0 - 0.5, (row + 0.5) * 48.0 - 0.5);
      Eigen::Vector3d bearing;
      Eigen::Vector2d of_a;
      EXPECT_TRUE(Unproject(*pose.b, pixel, &bearing));
      if (pose.a != nullptr) {
        if (!Project(*pose.a, pose.T_a_b * (distance * bearing), &of_a)) continue;
        if (of_a.minCoeff() < 0.0 || of_a.x() > 751.0 || of_a.y() > 479.0) continue;
      }
      seen.push_back(pixel);
    }
  }
  return seen;
}

// The pixel of b at which the point that it sees at `pixel` appears after a step of all parameters; where a
// is a camera, the point is where a then sees what it saw before, at the same distance.
Eigen::Vector2d PixelAfter(const UncertainPose& pose, double distance, const Eigen::Vector2d& pixel,
                           const Eigen::VectorXd& step) {
  Eigen::Vector3d bearing;
  Unproject(*pose.b, pixel, &bearing);
  Eigen::Vector3d in_a = pose.T_a_b * (distance * bearing);
  Eigen::Index next = 6;
  if (pose.a != nullptr) {
    const auto count = static_cast<Eigen::Index>(pose.a->parameters.size());
    Eigen::Vector2d of_a;
    Eigen::Vector3d bearing_of_a;
    Project(*pose.a, in_a, &of_a);
    Unproject(Moved(*pose.a, step.segment(next, count)), of_a, &bearing_of_a);
    in_a = in_a.norm() * bearing_of_a;
    next += count;
  }
  Eigen::Vector2d after;
  EXPECT_TRUE(Project(Moved(*pose.b, step.tail(step.size() - next)), Moved(pose.T_a_b, step).Inverse() * in_a,
                      &after));
  return after;
}

void ExpectAsDrawn(const UncertainPose& pose) {
  Random random(11);
  const std::vector<Eigen::VectorXd> steps = Draw(random, pose.covariance);
  const std::vector<SigmaInUse> uses = SigmasInImage(pose);
  ASSERT_EQ(uses.size(), 2u);
  for (const SigmaInUse& use : uses) {
    std::vector<double> sigmas;
    for (const Eigen::Vector2d& pixel : SeenPixels(pose, use.distance)) {
      Scatter<2> scatter;
      for (const Eigen::VectorXd& step : steps) {
        scatter.Add(PixelAfter(pose, use.distance, pixel, step) - pixel);
      }
      sigmas.push_back(scatter.LargestSigma());
    }
    const double worst = *std::max_element(sigmas.begin(), sigmas.end());
    EXPECT_EQ(use.where, SigmaInUse::Where::kImage);
    EXPECT_NEAR(use.worst, worst, 0.05 * worst) << use.distance << " m, " << sigmas.size() << " pixels";
    EXPECT_NEAR(use.median, Median(sigmas), 0.05 * Median(sigmas)) << use.distance << " m";
  }
}

TEST(SigmasInUse, PixelsOfACameraAreThoseOfPosesDrawnFromTheCovariance) {
  Random random(3);
  ExpectAsDrawn({{kLooksAhead * FromRollPitchYaw({0.1, -0.2, 0.05}), {0.3, -0.2, 0.4}},
                 nullptr,
                 &kLeft,
                 RandomCovariance(random, PoseSigmas(0, 9))});
}

TEST(SigmasInUse, PixelsOfTwoCamerasAreThoseOfPosesAndIntrinsicsDrawn) {
  Random random(4);
  const UncertainPose pose{{FromRollPitchYaw({0.02, 0.6, -0.03}), {0.21, 0.02, -0.01}},
                           &kRight,
                           &kLeft,
                           RandomCovariance(random, PoseSigmas(8, 9))};
  EXPECT_LT(SeenPixels(pose, 10.0).size(), 160u) << "the test is of a part in common";
  ExpectAsDrawn(pose);
}

TEST(SigmasInUse, CamerasThatSeeNothingInCommonHaveNone) {
  EXPECT_TRUE(SigmasInImage({{FromRollPitchYaw({0.0, M_PI, 0.0}), {0.0, 0.0, -0.2}},
                             &kLeft,
                             &kLeft,
                             Eigen::MatrixXd::Identity(24, 24)})
                  .empty());
}

// Along the optical axis, a turn about y and a move along x can leave the points at 10 m where they are.
TEST(SigmasInUse, ErrorsOfTurnAndMoveCancelWhereTheCovarianceSaysSo) {
  const double turn = 1e-3;
  Eigen::VectorXd error = Eigen::VectorXd::Zero(15);
  error[1] = turn;
  error[3] = -10.0 * turn;
  UncertainPose pose{{}, nullptr, &kLeft, error * error.transpose()};
  const std::vector<SigmaInUse> together = SigmasInImage(pose);
  pose.covariance = error.cwiseAbs2().asDiagonal();
  const std::vector<SigmaInUse> apart = SigmasInImage(pose);
  EXPECT_LT(together[0].median, 0.3 * apart[0].median);
  EXPECT_NEAR(together[1].median, 0.8 * turn * kLeft.parameters[0], 0.15);
}

TEST(SigmasInUse, CentimetresOfALidarAreThoseOfPosesDrawnFromTheCovariance) {
  Random random(5);
  const UncertainPose pose{{FromRollPitchYaw({0.4, -0.3, 2.0}), {1.2, -0.6, 0.3}},
                           nullptr,
                           nullptr,
                           RandomCovariance(random, PoseSigmas(0, 0))};
  const Eigen::Matrix3d R_a_vehicle = FromRollPitchYaw({0.1, 0.2, 1.3}).toRotationMatrix();
  const std::vector<Eigen::VectorXd> steps = Draw(random, pose.covariance);
  for (const SigmaInUse& use : SigmasInSpace(pose, R_a_vehicle)) {
    ASSERT_EQ(use.sectors.size(), 12u);
    std::vector<double> sigmas, sectors(12, 0.0);
    for (int azimuth = 5; azimuth < 360; azimuth += 10) {
      for (const int elevation : {-20, 0, 20}) {
        const Eigen::Vector3d direction =
            FromRollPitchYaw({0.0, -elevation * M_PI / 180.0, azimuth * M_PI / 180.0}) *
            Eigen::Vector3d::UnitX();
        const Eigen::Vector3d in_b =
            pose.T_a_b.rotation.conjugate() * (use.distance * (R_a_vehicle * direction));
        Scatter<3> scatter;
        for (const Eigen::VectorXd& step : steps) {
          scatter.Add(Moved(pose.T_a_b, step) * in_b - pose.T_a_b * in_b);
        }
        sigmas.push_back(scatter.LargestSigma());
        double& sector = sectors[static_cast<std::size_t>(azimuth / 30)];
        sector = std::max(sector, sigmas.back());
      }
    }
    EXPECT_EQ(use.where, SigmaInUse::Where::kSpace);
    EXPECT_NEAR(use.median, Median(sigmas), 0.05 * Median(sigmas));
    EXPECT_NEAR(use.worst, *std::max_element(sigmas.begin(), sigmas.end()), 0.05 * use.worst);
    for (std::size_t k = 0; k < 12; ++k) EXPECT_NEAR(use.sectors[k], sectors[k], 0.06 * sectors[k]) << k;
  }
}

// A roll lifts what is at the side and leaves what is ahead.
TEST(SigmasInUse, SectorsBeginAtTheFrontAndGoLeft) {
  Eigen::VectorXd variances = Eigen::VectorXd::Zero(6);
  variances[1] = 1e-6;  // about y of a frame whose y is the vehicle's front
  variances[3] = 1e-8;
  const Eigen::Matrix3d R_a_vehicle = FromRollPitchYaw({0.0, 0.0, 0.5 * M_PI}).toRotationMatrix();
  const std::vector<SigmaInUse> uses =
      SigmasInSpace({{}, nullptr, nullptr, variances.asDiagonal()}, R_a_vehicle);
  for (const std::size_t side : {2u, 3u, 8u, 9u}) EXPECT_NEAR(uses[1].sectors[side], 0.05, 1e-3);
  for (const std::size_t ahead : {0u, 5u, 6u, 11u}) EXPECT_LT(uses[1].sectors[ahead], 0.035);
}

// An error of the camera's yaw that its centre makes up for: together they are far better than either.
TEST(SigmasInUse, PairsAreGivenWithWhatPoseAndIntrinsicsHaveInCommon) {
  CalibrationState state;
  state.lidars.resize(2);
  state.lidars[1].T_imu_sensor = {FromRollPitchYaw({0.2, 0.1, 3.0}), {1.0, 0.2, 0.4}};
  state.cameras.resize(2);
  for (CameraCalibration& camera : state.cameras) camera.intrinsics = kLeft;
  state.cameras[1].sensor.T_imu_sensor = {kLooksAhead, {0.4, 0.1, 0.0}};
  const Layout layout(state, true);
  Eigen::VectorXd error = Eigen::VectorXd::Zero(layout.calibration);
  const double turn = 1e-3;
  error[layout.Camera(1) + 2] = turn;  // to the left, so that things move to the right in the image
  error[layout.Intrinsics(1) + 2] = -turn * kLeft.parameters[0];
  ObservabilityAnalysis analysis;
  analysis.whole_covariance = error * error.transpose();
  analysis.covariance = analysis.whole_covariance.topLeftCorner(layout.poses, layout.poses);
  const std::vector<SigmaInUse> pair = SigmasOfPair(state, analysis, 1, 3, Eigen::Matrix3d::Identity());
  ASSERT_EQ(pair.size(), 2u);
  EXPECT_LT(pair[0].median, 0.5 * turn * kLeft.parameters[0]);
  analysis.whole_covariance.bottomRows(layout.calibration - layout.poses).setZero();
  analysis.whole_covariance.rightCols(layout.calibration - layout.poses).setZero();
  const std::vector<SigmaInUse> pose_alone = SigmasOfPair(state, analysis, 1, 3, Eigen::Matrix3d::Identity());
  EXPECT_GT(pose_alone[0].median, turn * kLeft.parameters[0]);
  const std::vector<SigmaInUse> lidars = SigmasOfPair(state, analysis, 0, 1, Eigen::Matrix3d::Identity());
  EXPECT_EQ(lidars[0].worst, 0.0) << "the camera's error is not theirs";
}

}  // namespace
}  // namespace mlic::sigmas_in_use_test
