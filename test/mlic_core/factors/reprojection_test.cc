#include "mlic_core/factors/reprojection.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "mlic_core/common/random.h"
#include "mlic_core/geometry/so3.h"
#include "support/jacobian_check.h"

namespace mlic::reprojection_test {
namespace {

constexpr double kStamp = 0.43;

Eigen::Vector3d RandomVector(Random* random) {
  return {random->Normal(), random->Normal(), random->Normal()};
}

// Everything that the residual hangs on; moved along one column of the Jacobian at a time.
struct Unknowns {
  std::vector<Eigen::Quaterniond> rotations;
  std::vector<Eigen::Vector3d> positions;
  UniformKnots rotation_knots = UniformKnots::Covering(0.0, 1.0, 0.11);
  UniformKnots position_knots = UniformKnots::Covering(0.0, 1.0, 0.07);
  Eigen::Matrix3d R_imu_camera;
  Eigen::Vector3d p_imu_camera, point;
  double time_offset = 0.02, readout = 0.03;
  CameraIntrinsics intrinsics;
  Reprojection measurement;

  double Time() const { return measurement.Time(kStamp + time_offset, readout); }

  bool Evaluate(Eigen::Vector2d* residual, Reprojection::Jacobian* jacobian = nullptr) const {
    const SplitSpline trajectory{So3Spline(rotation_knots, rotations),
                                 PositionSpline(position_knots, positions)};
    return measurement.Evaluate(trajectory, SplineBasis(rotation_knots, Time()),
                                SplineBasis(position_knots, Time()),
                                {R_imu_camera, p_imu_camera, &intrinsics}, point, residual, jacobian);
  }

  void Move(int column, double step) {
    const int first_rotation = SplineBasis(rotation_knots, Time()).first;
    const int first_position = SplineBasis(position_knots, Time()).first;
    const auto unit = [&](int first_column) -> Eigen::Vector3d {
      return step * Eigen::Vector3d::Unit((column - first_column) % 3);
    };
    if (column < Reprojection::kPosition) {
      Eigen::Quaterniond& q = rotations[first_rotation + column / 3];
      q = q * ExpQuaternion(unit(0));
    } else if (column < Reprojection::kExtrinsic) {
      positions[first_position + (column - Reprojection::kPosition) / 3] += unit(Reprojection::kPosition);
    } else if (column < Reprojection::kExtrinsic + 3) {
      R_imu_camera = ExpMatrix(unit(Reprojection::kExtrinsic)) * R_imu_camera;
    } else if (column < Reprojection::kTimeOffset) {
      p_imu_camera += unit(Reprojection::kExtrinsic);
    } else if (column == Reprojection::kTimeOffset) {
      time_offset += step;
    } else if (column == Reprojection::kReadout) {
      readout += step;
    } else if (column < Reprojection::kIntrinsics) {
      point += unit(Reprojection::kPoint);
    } else {
      intrinsics.parameters[column - Reprojection::kIntrinsics] += step;
    }
  }
};

CameraIntrinsics Lens(CameraModel model) {
  CameraIntrinsics lens = IntrinsicsFromFieldOfView(model, 1280, 800, 100.0);
  std::vector<double>& p = lens.parameters;
  switch (model) {
    case CameraModel::kPlumbBob:
      p[4] = -0.2, p[5] = 0.03, p[6] = 1e-3, p[7] = -2e-3, p[8] = 0.004;
      break;
    case CameraModel::kRationalPolynomial:
      p[4] = 0.3, p[5] = 0.03, p[6] = 1e-3, p[7] = -2e-3, p[8] = 0.004, p[9] = 0.5, p[10] = 0.1, p[11] = 0.01;
      break;
    case CameraModel::kEquidistant:
      p[4] = 0.02, p[5] = -0.01, p[6] = 0.004, p[7] = -0.0005;
      break;
    case CameraModel::kDoubleSphere:
      p[4] = -0.1;
      break;
  }
  return lens;
}

// A random state in which the point is seen at `theta` from the optical axis.
Unknowns MakeUnknowns(CameraModel model, std::uint64_t seed, double theta) {
  Random random(seed);
  Unknowns unknowns;
  unknowns.rotations = {ExpQuaternion(RandomVector(&random))};
  while (static_cast<int>(unknowns.rotations.size()) < unknowns.rotation_knots.count) {
    unknowns.rotations.push_back(unknowns.rotations.back() * ExpQuaternion(0.2 * RandomVector(&random)));
  }
  for (int j = 0; j < unknowns.position_knots.count; ++j)
    unknowns.positions.push_back(0.3 * RandomVector(&random));
  unknowns.R_imu_camera = ExpMatrix(RandomVector(&random));
  unknowns.p_imu_camera = RandomVector(&random);
  unknowns.intrinsics = Lens(model);
  unknowns.measurement =
      Reprojection::Of({random.Uniform(0.0, 1279.0), random.Uniform(0.0, 799.0)}, unknowns.intrinsics);
  const double phi = random.Uniform(0.0, 2.0 * M_PI);
  const Eigen::Vector3d in_camera =
      random.Uniform(3.0, 20.0) *
      Eigen::Vector3d(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
  const SplitSpline trajectory{So3Spline(unknowns.rotation_knots, unknowns.rotations),
                               PositionSpline(unknowns.position_knots, unknowns.positions)};
  unknowns.point =
      trajectory.Pose(unknowns.Time()) * (unknowns.R_imu_camera * in_camera + unknowns.p_imu_camera);
  return unknowns;
}

constexpr CameraModel kModels[] = {CameraModel::kPlumbBob, CameraModel::kRationalPolynomial,
                                   CameraModel::kEquidistant, CameraModel::kDoubleSphere};

TEST(Reprojection, JacobianAgreesWithNumericOne) {
  for (const CameraModel model : kModels) {
    const bool fisheye = model == CameraModel::kEquidistant || model == CameraModel::kDoubleSphere;
    for (int seed = 1; seed <= 10; ++seed) {
      const Unknowns unknowns =
          MakeUnknowns(model, seed, (fisheye ? 0.175 : 0.08) * seed);  // up to 100 degrees
      Eigen::Vector2d residual;
      Reprojection::Jacobian jacobian;
      ASSERT_TRUE(unknowns.Evaluate(&residual, &jacobian));
      const int columns = Reprojection::kIntrinsics + ParameterCount(model);
      SCOPED_TRACE("model " + std::to_string(static_cast<int>(model)) + " seed " + std::to_string(seed));
      constexpr JacobianTolerance kTolerance{1e-6, 1e-5, 10.0};
      ExpectNumericJacobian(
          jacobian, columns,
          [&](int column, double step) {
            Unknowns moved = unknowns;
            moved.Move(column, step);
            Eigen::Vector2d value(NAN, NAN);
            EXPECT_TRUE(moved.Evaluate(&value));
            return value;
          },
          kTolerance);
      for (int c = columns; c < Reprojection::kColumns; ++c) EXPECT_EQ(jacobian.row(c).norm(), 0.0);
    }
  }
}

// The point as placed by the frames' definition is where the camera sees it.
TEST(Reprojection, VanishesAtTheTruth) {
  for (const CameraModel model : kModels) {
    Unknowns unknowns = MakeUnknowns(model, 3, 0.5);
    Eigen::Vector2d residual;
    ASSERT_TRUE(unknowns.Evaluate(&residual));
    unknowns.measurement.pixel += residual;  // its row share, so the time, stays
    ASSERT_TRUE(unknowns.Evaluate(&residual));
    EXPECT_LT(residual.norm(), 1e-9);
    const double axis_distance = (unknowns.measurement.pixel - Eigen::Vector2d(639.5, 399.5)).norm() /
                                 unknowns.intrinsics.parameters[0];
    EXPECT_NEAR(axis_distance, 0.5, 0.1);
  }
}

TEST(Reprojection, ReadoutDelaysLowerRows) {
  const CameraIntrinsics lens = Lens(CameraModel::kPlumbBob);
  EXPECT_DOUBLE_EQ(Reprojection::Of({3.0, 0.0}, lens).Time(5.25, 0.02), 5.25);
  EXPECT_DOUBLE_EQ(Reprojection::Of({3.0, 400.0}, lens).Time(5.25, 0.02), 5.26);
  EXPECT_DOUBLE_EQ(Reprojection::Of({3.0, 400.0}, lens).Time(5.25, 0.0), 5.25);
}

TEST(Reprojection, UnseenPointIsSaidAndNothingWritten) {
  const Unknowns unknowns = MakeUnknowns(CameraModel::kPlumbBob, 4, 2.0);
  Eigen::Vector2d residual(7.0, 8.0);
  EXPECT_FALSE(unknowns.Evaluate(&residual));
  EXPECT_EQ(residual, Eigen::Vector2d(7.0, 8.0));
}

}  // namespace
}  // namespace mlic::reprojection_test
