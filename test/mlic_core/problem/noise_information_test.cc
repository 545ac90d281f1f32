#include "mlic_core/problem/noise_information.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <random>

#include "mlic_core/factors/imu_residual.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/problem/joint_solver.h"
#include "mlic_core/problem/layout.h"

namespace mlic::noise_information_test {
namespace {

constexpr double kRate = 200.0;     // Hz
constexpr double kDuration = 20.0;  // s
constexpr ImuNoise kNoise{1e-3, 1e-2};

// An IMU on a level turntable that goes to and fro; poses are known to 1 mrad and 1 cm. The accelerometer's
// rotation about the vertical leaves gravity as it is: only the horizontal acceleration shows it.
class Turntable : public testing::Test {
 protected:
  SolveSummary Solve(double amplitude, double noise) {
    const UniformKnots knots = UniformKnots::Covering(0.0, kDuration, 0.05);
    std::vector<Eigen::Quaterniond> rotations;
    std::vector<Eigen::Vector3d> positions;
    for (int k = 0; k < knots.count; ++k) {
      const double angle = kYawRate * (k - 1) * 0.05;
      rotations.push_back(ExpQuaternion({0.0, 0.0, angle}));
      positions.push_back({amplitude * std::sin(4.0 * angle), 0.0, 0.0});
    }
    DriveState drive;
    drive.trajectory.rotation = So3Spline(knots, rotations);
    drive.trajectory.position = PositionSpline(knots, positions);
    state_.drives = {drive};
    MeasureDrive(noise);
    return SolveJointProblem(problem_, 4, CancellationToken(), &state_);
  }
  // What of the alignment about the vertical, 1/rad^2, the information leaves once all else is free that the
  // problem does not hold.
  static double Heading(const Eigen::MatrixXd& information, const CalibrationState& state) {
    const Layout layout(state, false);
    Eigen::MatrixXd known = information;
    known.diagonal().array() += 1e-3;
    known(layout.lag, layout.lag) += 1e12;
    return 1.0 / known.inverse()(layout.alignment + 2, layout.alignment + 2);
  }
  Eigen::VectorXd Limits() const {
    return Eigen::VectorXd::Constant(Layout(state_, false).calibration, 0.01);
  }

  static constexpr double kYawRate = 0.5;  // rad/s
  Dataset dataset_;
  JointProblem problem_;
  CalibrationState state_;

 private:
  void MeasureDrive(double noise) {
    std::mt19937_64 engine(3);
    std::normal_distribution<double> draw;
    const auto random = [&] { return Eigen::Vector3d(draw(engine), draw(engine), draw(engine)); };
    const SplitSpline& trajectory = state_.drives[0].trajectory;
    dataset_.drives.resize(1);
    problem_.dataset = &dataset_;
    problem_.imu.alignment_sigma = ImuConfig().alignment_sigma;
    problem_.imu.alignment_shown.setIdentity();
    DriveTerms& terms = problem_.drives.emplace_back();
    terms.poses = {{}, 1e-3, 0.01};
    terms.imu_sigma.usual = {Eigen::Vector3d::Constant(kNoise.gyroscope * std::sqrt(kRate)),
                             Eigen::Vector3d::Constant(kNoise.accelerometer * std::sqrt(kRate))};
    for (int i = 0; i < static_cast<int>(kDuration * kRate); ++i) {
      const double t = (i + 0.5) / kRate;
      ImuSample sample{t, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
      const Eigen::Matrix<double, 6, 1> measured = ImuResidual::Evaluate(
          trajectory, {trajectory, t, 0.0}, state_.Imu(0, t), state_.Gravity(), sample, nullptr);
      sample.angular_velocity =
          measured.head<3>() + noise * terms.imu_sigma.usual.gyroscope.cwiseProduct(random());
      sample.specific_force =
          measured.tail<3>() + noise * terms.imu_sigma.usual.accelerometer.cwiseProduct(random());
      dataset_.drives[0].imu.push_back(sample);
      if (i % 20 != 0) continue;
      RigidTransform T = trajectory.Pose(t);
      T.rotation = T.rotation * ExpQuaternion(1e-3 * noise * random());
      T.translation += 0.01 * noise * random();
      terms.poses.T_map_imu.push_back({t, T});
    }
  }
};

TEST_F(Turntable, WithoutMotionOnlyTheNoiseShowsTheHeading) {
  const SolveSummary summary = Solve(0.0, 1.0);
  const Eigen::MatrixXd noise = NoiseInformation({problem_, state_}, CancellationToken());
  const double claimed = Heading(summary.information, state_);
  EXPECT_GT(claimed, 1.0);
  EXPECT_LT(Heading(WithoutNoise(summary.information, noise, Limits()).information, state_), 0.02 * claimed);
}

TEST_F(Turntable, MotionThatShowsTheHeadingKeepsItsInformation) {
  const SolveSummary summary = Solve(0.3, 1.0);
  const Eigen::MatrixXd noise = NoiseInformation({problem_, state_}, CancellationToken());
  const double claimed = Heading(summary.information, state_);
  EXPECT_GT(Heading(WithoutNoise(summary.information, noise, Limits()).information, state_), 0.85 * claimed);
  EXPECT_LT(Heading(WithoutNoise(summary.information, noise, Limits()).information, state_), claimed);
}

// Two parameters that are known together, half of one of them by noise.
TEST(FreedOfNoise, ItsEquationsPutAnEstimateOffByWhatOnlyTheRestPulls) {
  Eigen::Matrix2d S, noise;
  S << 4.0e4, 1.0e4, 1.0e4, 9.0e4;
  noise << 2.0e4, 1.0e3, 1.0e3, 0.5e4;
  const FreedOfNoise freed = WithoutNoise(S, noise, Eigen::Vector2d(0.01, 0.05));
  const Eigen::Vector2d gradient(300.0, -200.0);
  const Eigen::Vector2d off = freed.information.inverse() * freed.by_gradient * gradient;
  EXPECT_LT((off - (S - noise).inverse() * gradient).norm(), 1e-9 * off.norm());
  const Eigen::MatrixXd of_gradient = freed.by_gradient * S * freed.by_gradient.transpose();
  EXPECT_LT((of_gradient - freed.information).norm(), 1e-9 * freed.information.norm());
}

// A lag of 30 ms would hardly be seen by accelerations that are not there.
TEST_F(Turntable, WithoutMotionTheNoiseHardlyShowsTheLag) {
  const SolveSummary summary = Solve(0.0, 1.0);
  const int lag = Layout(state_, false).lag;
  EXPECT_LT(summary.information(lag, lag), 1.0 / (0.03 * 0.03));
}

}  // namespace
}  // namespace mlic::noise_information_test
