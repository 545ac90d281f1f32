#include <gtest/gtest.h>

#include "mlic_core/common/random.h"
#include "mlic_core/factors/gauge.h"
#include "mlic_core/factors/imu_residual.h"
#include "mlic_core/factors/lidar_point.h"
#include "mlic_core/factors/point_to_plane.h"
#include "mlic_core/factors/pose.h"
#include "mlic_core/problem/layout.h"
#include "support/jacobian_check.h"

namespace mlic::jacobians_test {
namespace {

Eigen::Vector3d RandomVector(Random* random) {
  return {random->Normal(), random->Normal(), random->Normal()};
}

CalibrationState RandomState(std::uint64_t seed) {
  Random random(seed);
  CalibrationState state;
  const UniformKnots rotation = UniformKnots::Covering(0.0, 1.0, 0.11);
  const UniformKnots position = UniformKnots::Covering(0.0, 1.0, 0.07);
  std::vector<Eigen::Quaterniond> rotations{ExpQuaternion(RandomVector(&random))};
  while (static_cast<int>(rotations.size()) < rotation.count) {
    rotations.push_back(rotations.back() * ExpQuaternion(0.2 * RandomVector(&random)));
  }
  std::vector<Eigen::Vector3d> positions;
  for (int j = 0; j < position.count; ++j) positions.push_back(0.3 * RandomVector(&random));
  DriveState drive;
  drive.trajectory = {So3Spline(rotation, rotations), PositionSpline(position, positions)};
  const Eigen::Vector3d gyroscope_bias = 0.1 * RandomVector(&random);
  drive.bias = {gyroscope_bias, 0.1 * RandomVector(&random)};
  state.drives.push_back(drive);
  SensorCalibration lidar;
  lidar.T_imu_sensor = {ExpQuaternion(RandomVector(&random)), RandomVector(&random)};
  lidar.time_offset = 0.05;
  state.lidars.push_back(lidar);
  state.gyroscope_matrix += 0.01 * Eigen::Matrix3d::Random();
  state.accelerometer_matrix = ExpMatrix(0.05 * RandomVector(&random));
  const Eigen::Vector3d axis = RandomVector(&random).normalized();
  state.accelerometer_axes = axis * axis.transpose();
  state.gravity = 9.79;
  state.accelerometer_lag = 0.004;
  return state;
}

// The state with one unknown (Layout) moved.
CalibrationState Moved(const CalibrationState& state, const Layout& layout, int column, double step) {
  CalibrationState moved = state;
  Eigen::VectorXd delta = Eigen::VectorXd::Zero(layout.Total());
  delta[column] = step;
  layout.Update(delta, &moved);
  return moved;
}

Eigen::Matrix<double, 1, 1> One(double value) { return Eigen::Matrix<double, 1, 1>(value); }

constexpr double kTime = 0.43;

SplineBasis RotationBasis(const CalibrationState& state, double t) {
  return SplineBasis(state.drives[0].trajectory.rotation.knots(), t);
}
SplineBasis PositionBasis(const CalibrationState& state, double t) {
  return SplineBasis(state.drives[0].trajectory.position.knots(), t);
}

double PointResidual(const CalibrationState& state, const PointToPlane& plane, const Eigen::Vector3d& x,
                     double* row) {
  const double t = kTime + state.lidars[0].time_offset;
  const PointToPlane::Extrinsic extrinsic{state.lidars[0].T_imu_sensor.rotation.toRotationMatrix(),
                                          state.lidars[0].T_imu_sensor.translation};
  return plane.Evaluate(state.drives[0].trajectory, RotationBasis(state, t), PositionBasis(state, t),
                        extrinsic, x, row);
}

// The cosine of the incidence of a beam on a plane.
double Facing(const CalibrationState& state, const Eigen::Vector3d& x, const PointToPlane& plane) {
  const double t = kTime + state.lidars[0].time_offset;
  const Eigen::Matrix3d R = state.drives[0].trajectory.rotation.Evaluate(RotationBasis(state, t)).rotation;
  return -plane.normal.dot(R * (state.lidars[0].T_imu_sensor.rotation * x.normalized()));
}

// Turns the normal to the sensor that sees the point x.
void FaceSensor(const CalibrationState& state, const Eigen::Vector3d& x, PointToPlane* plane) {
  if (Facing(state, x, *plane) < 0.0) plane->normal = -plane->normal;
}

// The columns of the unknowns that a measurement's row refers to.
std::vector<int> KnotColumns(const Layout& layout, const CalibrationState& state, double t) {
  std::vector<int> columns;
  for (int j = 0; j < 4; ++j) {
    for (int a = 0; a < 3; ++a)
      columns.push_back(layout.drives[0].rotation[RotationBasis(state, t).first + j] + a);
  }
  for (int j = 0; j < 4; ++j) {
    for (int a = 0; a < 3; ++a)
      columns.push_back(layout.drives[0].position[PositionBasis(state, t).first + j] + a);
  }
  return columns;
}

TEST(PointToPlane, JacobianAgreesWithNumericOne) {
  const CalibrationState state = RandomState(3);
  const Layout layout(state, false);
  PointToPlane plane;
  plane.normal = Eigen::Vector3d(0.3, -0.5, 0.8).normalized();
  plane.tangent_u = plane.normal.unitOrthogonal();
  plane.tangent_v = plane.normal.cross(plane.tangent_u);
  plane.anchor = Eigen::Vector3d(1.0, 2.0, -0.5);
  const Eigen::Vector3d x(3.0, -2.0, 5.0);
  FaceSensor(state, x, &plane);
  double row[PointToPlane::kColumns];
  PointResidual(state, plane, x, row);
  std::vector<int> columns = KnotColumns(layout, state, kTime + state.lidars[0].time_offset);
  for (int i = 0; i < 7; ++i) columns.push_back(layout.knots + i);
  const Eigen::Map<const Eigen::VectorXd> J(row, PointToPlane::kColumns);
  constexpr JacobianTolerance kTolerance{1e-6, 1e-6, 1.0};
  ExpectNumericJacobian(
      J, PointToPlane::kColumns,
      [&](int column, double step) {
        PointToPlane moved = plane;
        if (column == PointToPlane::kPlane)
          moved.normal = (plane.normal + step * plane.tangent_u).normalized();
        if (column == PointToPlane::kPlane + 1) {
          moved.normal = (plane.normal + step * plane.tangent_v).normalized();
        }
        if (column == PointToPlane::kPlane + 2) moved.offset += step;
        const CalibrationState at =
            column < PointToPlane::kPlane ? Moved(state, layout, columns[column], step) : state;
        return One(PointResidual(at, moved, x, nullptr));
      },
      kTolerance);
}

// Noise of the range must not pull: the gradient's mean at the truth is zero (errors in variables).
TEST(PointToPlane, RangeNoiseDoesNotBias) {
  const CalibrationState state = RandomState(3);
  PointToPlane plane;
  plane.normal = Eigen::Vector3d(0.3, -0.5, 0.8).normalized();
  plane.anchor = Eigen::Vector3d(1.0, 2.0, -0.5);
  const Eigen::Vector3d direction = Eigen::Vector3d(3.0, -2.0, 5.0).normalized();
  FaceSensor(state, direction, &plane);
  plane.tangent_u = plane.normal.unitOrthogonal();
  plane.tangent_v = plane.normal.cross(plane.tangent_u);
  const double range = 6.0;
  plane.offset = PointResidual(state, plane, range * direction, nullptr) * Facing(state, direction, plane);
  ASSERT_NEAR(PointResidual(state, plane, range * direction, nullptr), 0.0, 1e-12);
  Random random(7);
  constexpr int kDraws = 20000;
  using Row = Eigen::Matrix<double, PointToPlane::kColumns, 1>;
  Row sum = Row::Zero(), squares = Row::Zero(), row;
  for (int i = 0; i < kDraws; ++i) {
    const double r = PointResidual(state, plane, (range + 0.05 * random.Normal()) * direction, row.data());
    sum += r * row;
    squares += (r * row).cwiseAbs2();
  }
  for (int c = 0; c < row.size(); ++c) {
    EXPECT_LE(std::abs(sum[c]), 4.0 * std::sqrt(squares[c]) + 1e-12) << "column " << c;
  }
}

// time: of the sample, s.
void ExpectImuJacobian(CalibrationState state, double time) {
  // A cubic in time: the jerk is what its mean over a knot spacing is.
  const UniformKnots& knots = state.drives[0].trajectory.position.knots();
  std::vector<Eigen::Vector3d> positions;
  for (int j = 0; j < knots.count; ++j) {
    const double t = knots.ControlPointTime(j);
    positions.push_back({t * t * t, 2.0 * t * t - 3.0 * t * t * t, t + 4.0 * t * t * t});
  }
  state.drives[0].trajectory.position = PositionSpline(knots, positions);
  const Layout layout(state, true);
  ImuSample sample;
  sample.time = time;
  sample.specific_force = Eigen::Vector3d(0.1, 9.0, 1.0);
  const auto evaluate = [&](const CalibrationState& at, ImuResidual::Jacobian* J) {
    const ImuBases bases(at.drives[0].trajectory, time, at.accelerometer_lag);
    return ImuResidual::Evaluate(at.drives[0].trajectory, bases, at.Imu(0, sample.time), at.Gravity(), sample,
                                 J);
  };
  ImuResidual::Jacobian J;
  evaluate(state, &J);
  ImuResidual::TurnOne(state.accelerometer_axes, &J);
  // The rates' control points are those at the sample's time, the specific force's those of the lag before.
  for (const bool of_force : {false, true}) {
    std::vector<int> columns = KnotColumns(layout, state, of_force ? time - state.accelerometer_lag : time);
    for (int i = 0; i < 6; ++i) columns.push_back(layout.knots + layout.Bias(0, 0) + i);
    columns.push_back(layout.knots + layout.gravity);
    columns.push_back(layout.knots + layout.lag);
    for (int i = 0; i < 3; ++i) columns.push_back(layout.knots + layout.alignment + i);
    for (int i = 0; i < Layout::kOfMatrices; ++i) columns.push_back(layout.knots + layout.matrices + i);
    const int first = of_force ? 3 : 0;
    ExpectNumericJacobian(J.middleCols<3>(first), ImuResidual::kColumns, [&](int column, double step) {
      const Eigen::Matrix<double, 6, 1> r = evaluate(Moved(state, layout, columns[column], step), nullptr);
      return Eigen::Vector3d(r.segment<3>(first));
    });
  }
}

TEST(ImuResidual, JacobianAgreesWithNumericOne) { ExpectImuJacobian(RandomState(5), kTime); }

// Knots of the rotation lie every 0.11 s, of the position every 0.07 s: a lag of 4 ms.
TEST(ImuResidual, JacobianAgreesWhereTheLagReachesIntoAnotherSegment) {
  ExpectImuJacobian(RandomState(5), 0.442);
  ExpectImuJacobian(RandomState(5), 0.352);
}

TEST(LidarPointResidual, JacobianAgreesWithNumericOne) {
  const CalibrationState state = RandomState(7);
  const Layout layout(state, false);
  const LidarPointResidual factor{{3.0, -2.0, 5.0}, 0.02, 0.1};
  const Eigen::Vector3d P(4.0, 1.0, -2.0);
  const auto evaluate = [&](const CalibrationState& at, const Eigen::Vector3d& point,
                            LidarPointResidual::Jacobian* J) {
    const double t = kTime + at.lidars[0].time_offset;
    return factor.Evaluate(at.drives[0].trajectory, RotationBasis(at, t), PositionBasis(at, t), at.lidars[0],
                           point, J);
  };
  LidarPointResidual::Jacobian J;
  evaluate(state, P, &J);
  std::vector<int> columns = KnotColumns(layout, state, kTime + state.lidars[0].time_offset);
  for (int i = 0; i < 7; ++i) columns.push_back(layout.knots + i);
  ExpectNumericJacobian(J, LidarPointResidual::kColumns, [&](int column, double step) {
    if (column < LidarPointResidual::kPoint) {
      return evaluate(Moved(state, layout, columns[column], step), P, nullptr);
    }
    const Eigen::Vector3d unit = Eigen::Vector3d::Unit(column - LidarPointResidual::kPoint);
    return evaluate(state, P + step * unit, nullptr);
  });
}

// The point where it was measured has no residual, a tenth of a metre farther along the beam five sigmas.
TEST(LidarPointResidual, IsWhitenedAcrossAndAlongTheBeam) {
  const CalibrationState state = RandomState(8);
  const LidarPointResidual factor{{3.0, -2.0, 5.0}, 0.02, 0.1};
  const double t = kTime + state.lidars[0].time_offset;
  const SplitSpline& trajectory = state.drives[0].trajectory;
  const RigidTransform T_map_lidar = trajectory.Pose(t) * state.lidars[0].T_imu_sensor;
  const auto evaluate = [&](const Eigen::Vector3d& in_lidar) {
    return factor.Evaluate(trajectory, RotationBasis(state, t), PositionBasis(state, t), state.lidars[0],
                           T_map_lidar * in_lidar);
  };
  EXPECT_LT(evaluate(factor.position).norm(), 1e-9);
  const Eigen::Vector3d beam = factor.position.normalized();
  EXPECT_LT((evaluate(factor.position + 0.1 * beam) - Eigen::Vector3d(0.0, 0.0, 5.0)).norm(), 1e-9);
  EXPECT_NEAR(evaluate(factor.position + 0.1 * beam.unitOrthogonal()).norm(), 1.0, 1e-9);
}

TEST(PoseResidual, JacobianAgreesWithNumericOne) {
  const CalibrationState state = RandomState(9);
  const Layout layout(state, false);
  const PoseResidual factor{{ExpQuaternion({0.3, -1.2, 0.5}), Eigen::Vector3d(1.0, 2.0, -0.5)}, 0.01, 0.03};
  const auto evaluate = [&](const CalibrationState& at, PoseResidual::Jacobian* J) {
    return factor.Evaluate(at.drives[0].trajectory, RotationBasis(at, kTime), PositionBasis(at, kTime), J);
  };
  PoseResidual::Jacobian J;
  evaluate(state, &J);
  const std::vector<int> columns = KnotColumns(layout, state, kTime);
  ExpectNumericJacobian(J, PoseResidual::kColumns, [&](int column, double step) {
    return evaluate(Moved(state, layout, columns[column], step), nullptr);
  });
}

TEST(GaugeResidual, JacobianAgreesWithNumericOneWhereItIsZero) {
  const CalibrationState state = RandomState(10);
  const Layout layout(state, false);
  const RigidTransform T = state.drives[0].trajectory.Pose(kTime);
  const auto sensor_of = [](const CalibrationState& at) {
    return at.lidars[0].T_imu_sensor.rotation.toRotationMatrix();
  };
  const Eigen::Matrix3d R_fixed = T.rotation.toRotationMatrix() * sensor_of(state);
  const auto evaluate = [&](const CalibrationState& at) {
    const GaugeResidual factor{R_fixed, T.translation, sensor_of(at)};
    return factor.Evaluate(at.drives[0].trajectory, RotationBasis(at, kTime), PositionBasis(at, kTime));
  };
  EXPECT_LT(evaluate(state).norm(), 1e-9 * GaugeResidual::kScale);
  const GaugeResidual::Jacobian J = GaugeResidual::JacobianAtZero(
      state.drives[0].trajectory, RotationBasis(state, kTime), PositionBasis(state, kTime));
  std::vector<int> columns = KnotColumns(layout, state, kTime);
  for (int i = 0; i < 3; ++i) columns.push_back(layout.knots + Layout::Lidar(0) + i);
  ExpectNumericJacobian(J, GaugeResidual::kColumns, [&](int column, double step) {
    return evaluate(Moved(state, layout, columns[column], step));
  });
}

}  // namespace
}  // namespace mlic::jacobians_test
