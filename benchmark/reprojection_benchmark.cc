// Time of the reprojection residual with all its Jacobians on one core: closed form against Ceres' automatic
// differentiation of the same residual with a plumb_bob camera; and of the camera models alone. Before any
// timing both must agree on value and derivative.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <vector>

#include "autodiff_residuals.h"
#include "mlic_core/common/random.h"
#include "mlic_core/factors/reprojection.h"
#include "mlic_core/geometry/so3.h"

namespace mlic {
namespace {

constexpr int kSamples = 512;
constexpr double kRotationSpacing = 0.02, kPositionSpacing = 0.05;
constexpr double kReadout = 0.03;

// Parameter blocks: 4 rotations (4), 4 positions (3), intrinsics (9), and one of extrinsic rotation (4),
// extrinsic translation (3), time offset (1), readout (1), point (3).
struct ReprojectionAutodiff {
  double u_rotation, u_position;  // normalised times in the segments at time offset and readout 0
  Eigen::Vector2d pixel;
  double row_share;

  template <typename T>
  bool operator()(const T* r0, const T* r1, const T* r2, const T* r3, const T* p0, const T* p1, const T* p2,
                  const T* p3, const T* intrinsics, const T* other, T* residual) const {
    const T* rotations[4] = {r0, r1, r2, r3};
    const T* positions[4] = {p0, p1, p2, p3};
    const T delay = other[7] + T(row_share) * other[8];
    Eigen::Matrix<T, 4, 1> lambda, lambda_dot;
    PointToPlaneAutodiff::Basis<T>(T(u_rotation) + delay / T(kRotationSpacing), kRotationSpacing, &lambda,
                                   &lambda_dot);
    Eigen::Quaternion<T> rotation;
    Vector3<T> velocity;
    EvaluateRotation<T>(rotations, lambda, lambda_dot, &rotation, &velocity);
    PointToPlaneAutodiff::Basis<T>(T(u_position) + delay / T(kPositionSpacing), kPositionSpacing, &lambda,
                                   &lambda_dot);
    const Eigen::Quaternion<T> R_imu_camera = Eigen::Map<const Eigen::Quaternion<T>>(other);
    const Vector3<T> from_imu =
        Eigen::Map<const Vector3<T>>(other + 9) - EvaluatePosition<T>(positions, lambda);
    const Vector3<T> in_imu = rotation.conjugate() * from_imu;
    const Vector3<T> q =
        R_imu_camera.conjugate() * Vector3<T>(in_imu - Eigen::Map<const Vector3<T>>(other + 4));
    const T x = q.x() / q.z(), y = q.y() / q.z(), s = x * x + y * y;
    const T* d = intrinsics + 4;
    const T radial = T(1) + s * (d[0] + s * (d[1] + s * d[4]));
    residual[0] = intrinsics[0] * (x * radial + T(2) * d[2] * x * y + d[3] * (s + T(2) * x * x)) +
                  intrinsics[2] - T(pixel.x());
    residual[1] = intrinsics[1] * (y * radial + d[2] * (s + T(2) * y * y) + T(2) * d[3] * x * y) +
                  intrinsics[3] - T(pixel.y());
    return true;
  }

  static ceres::CostFunction* Create(const ReprojectionAutodiff& residual) {
    return new ceres::AutoDiffCostFunction<ReprojectionAutodiff, 2, 4, 4, 4, 4, 3, 3, 3, 3, 9, 12>(
        new ReprojectionAutodiff(residual));
  }
};

Eigen::Vector3d RandomVector(Random& random) { return {random.Normal(), random.Normal(), random.Normal()}; }

CameraIntrinsics Lens(CameraModel model) {
  CameraIntrinsics lens = IntrinsicsFromFieldOfView(model, 1280, 800, 90.0);
  if (model == CameraModel::kDoubleSphere) return lens;
  lens.parameters[4] = model == CameraModel::kEquidistant ? -0.02 : -0.28;
  lens.parameters[5] = 0.06;
  if (model == CameraModel::kRationalPolynomial) lens.parameters[9] = 0.1;
  return lens;
}

struct Setup {
  SplitSpline trajectory;
  std::vector<double> stamps;
  std::vector<Eigen::Vector3d> in_camera, points;
  std::vector<Reprojection> measurements;
  CameraIntrinsics lens;
  Eigen::Quaterniond q_imu_camera = ExpQuaternion({0.3, -0.2, 0.5});
  Reprojection::Camera camera;

  explicit Setup(CameraModel model) : lens(Lens(model)) {
    Random random(1);
    const UniformKnots rotation_knots = UniformKnots::Covering(0.0, 10.0, kRotationSpacing);
    std::vector<Eigen::Quaterniond> rotations(1, Eigen::Quaterniond::Identity());
    while (static_cast<int>(rotations.size()) < rotation_knots.count)
      rotations.push_back((rotations.back() * ExpQuaternion(0.02 * RandomVector(random))).normalized());
    const UniformKnots position_knots = UniformKnots::Covering(0.0, 10.0, kPositionSpacing);
    std::vector<Eigen::Vector3d> positions(1, Eigen::Vector3d::Zero());
    while (static_cast<int>(positions.size()) < position_knots.count)
      positions.push_back(positions.back() + 0.05 * RandomVector(random));
    trajectory = {So3Spline(rotation_knots, rotations), PositionSpline(position_knots, positions)};
    camera = {q_imu_camera.toRotationMatrix(), Eigen::Vector3d(0.1, 1.5, -0.2), &lens};
    for (int i = 0; i < kSamples; ++i) {
      stamps.push_back(random.Uniform(0.5, 9.5));
      measurements.push_back(
          Reprojection::Of({random.Uniform(0.0, 1279.0), random.Uniform(0.0, 799.0)}, lens));
      in_camera.push_back(random.Uniform(2.0, 30.0) *
                          Eigen::Vector3d(random.Uniform(-0.7, 0.7), random.Uniform(-0.6, 0.6), 1.0));
      points.push_back(trajectory.Pose(measurements[i].Time(stamps[i], kReadout)) *
                       (camera.R_imu_camera * in_camera[i] + camera.p_imu_camera));
    }
  }
  Setup(const Setup&) = delete;

  bool Closed(int i, Eigen::Vector2d* residual, Reprojection::Jacobian* jacobian) const {
    const double t = measurements[i].Time(stamps[i], kReadout);
    return measurements[i].Evaluate(trajectory, SplineBasis(trajectory.rotation.knots(), t),
                                    SplineBasis(trajectory.position.knots(), t), camera, points[i], residual,
                                    jacobian);
  }
};

// A cost function of Ceres with its parameter blocks and room for residual and Jacobians.
struct AutodiffCall {
  std::unique_ptr<ceres::CostFunction> cost;
  std::vector<const double*> parameters;
  std::vector<double> tail;
  std::vector<std::vector<double>> storage;
  std::vector<double*> jacobians;
  Eigen::Vector2d residual;

  AutodiffCall(const Setup& setup, int i) {
    const double exposed = setup.measurements[i].Time(setup.stamps[i], kReadout);
    const UniformKnots& rotation_knots = setup.trajectory.rotation.knots();
    const UniformKnots& position_knots = setup.trajectory.position.knots();
    const int rotation = SplineBasis(rotation_knots, exposed).first;
    const int position = SplineBasis(position_knots, exposed).first;
    const auto normalised = [&](const UniformKnots& knots, int first) {
      return (setup.stamps[i] - knots.start) / knots.spacing - first;
    };
    cost.reset(ReprojectionAutodiff::Create({normalised(rotation_knots, rotation),
                                             normalised(position_knots, position),
                                             setup.measurements[i].pixel, setup.measurements[i].row_share}));
    for (int j = 0; j < 4; ++j)
      parameters.push_back(setup.trajectory.rotation.control_points()[rotation + j].coeffs().data());
    for (int j = 0; j < 4; ++j)
      parameters.push_back(setup.trajectory.position.control_points()[position + j].data());
    parameters.push_back(setup.lens.parameters.data());
    const Eigen::Vector4d q = setup.q_imu_camera.coeffs();
    const Eigen::Vector3d &p = setup.camera.p_imu_camera, &P = setup.points[i];
    tail = {q[0], q[1], q[2], q[3], p[0], p[1], p[2], 0.0, kReadout, P[0], P[1], P[2]};
    parameters.push_back(tail.data());
    for (const int size : cost->parameter_block_sizes()) storage.emplace_back(2 * size);
    for (std::vector<double>& block : storage) jacobians.push_back(block.data());
  }
  void Evaluate() { cost->Evaluate(parameters.data(), residual.data(), jacobians.data()); }
};

// Largest difference between both ways, relative to the size of values and derivatives, of those derivatives
// that have the same parameters: all but rotations'.
double LargestDifference() {
  const Setup setup(CameraModel::kPlumbBob);
  double largest = 0.0;
  for (int i = 0; i < kSamples; ++i) {
    AutodiffCall call(setup, i);
    call.Evaluate();
    Eigen::Vector2d residual;
    Reprojection::Jacobian J;
    if (!setup.Closed(i, &residual, &J)) return 1e9;
    const auto compare = [&](double automatic, double closed) {
      largest = std::max(largest, std::abs(automatic - closed) / (1.0 + std::abs(automatic)));
    };
    for (int k = 0; k < 2; ++k) {
      compare(call.residual[k], residual[k]);
      for (int c = 0; c < 12; ++c)
        compare(call.jacobians[4 + c / 3][3 * k + c % 3], J(Reprojection::kPosition + c, k));
      for (int c = 0; c < 9; ++c) compare(call.jacobians[8][9 * k + c], J(Reprojection::kIntrinsics + c, k));
      const double* other = call.jacobians[9] + 12 * k;
      for (int c = 0; c < 3; ++c) compare(other[4 + c], J(Reprojection::kExtrinsic + 3 + c, k));
      compare(other[7], J(Reprojection::kTimeOffset, k));
      compare(other[8], J(Reprojection::kReadout, k));
      for (int c = 0; c < 3; ++c) compare(other[9 + c], J(Reprojection::kPoint + c, k));
    }
  }
  return largest;
}

void ReprojectionClosedForm(benchmark::State& state) {
  const Setup setup(static_cast<CameraModel>(state.range(0)));
  Eigen::Vector2d residual;
  Reprojection::Jacobian jacobian;
  int i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(setup.Closed(i++ % kSamples, &residual, &jacobian));
    benchmark::DoNotOptimize(jacobian.data());
    benchmark::ClobberMemory();
  }
}
BENCHMARK(ReprojectionClosedForm)->DenseRange(0, 3)->ArgName("model");

void ReprojectionCeresAutodiff(benchmark::State& state) {
  const Setup setup(CameraModel::kPlumbBob);
  std::vector<AutodiffCall> calls;
  for (int i = 0; i < kSamples; ++i) calls.emplace_back(setup, i);
  int i = 0;
  for (auto _ : state) {
    calls[i++ % kSamples].Evaluate();
    benchmark::ClobberMemory();
  }
}
BENCHMARK(ReprojectionCeresAutodiff);

void ProjectWithJacobians(benchmark::State& state) {
  const Setup setup(static_cast<CameraModel>(state.range(0)));
  Eigen::Vector2d pixel;
  CameraPointJacobian J_point;
  CameraParameterJacobian J_parameters;
  int i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        Project(setup.lens, setup.in_camera[i++ % kSamples], &pixel, &J_point, &J_parameters));
    benchmark::ClobberMemory();
  }
}
BENCHMARK(ProjectWithJacobians)->DenseRange(0, 3)->ArgName("model");

void UnprojectPixel(benchmark::State& state) {
  const Setup setup(static_cast<CameraModel>(state.range(0)));
  Eigen::Vector3d bearing;
  int i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(Unproject(setup.lens, setup.measurements[i++ % kSamples].pixel, &bearing));
    benchmark::ClobberMemory();
  }
}
BENCHMARK(UnprojectPixel)->DenseRange(0, 3)->ArgName("model");

}  // namespace
}  // namespace mlic

int main(int argc, char** argv) {
  const double difference = mlic::LargestDifference();
  if (!(difference < 1e-8)) {
    std::fprintf(stderr, "reprojection_benchmark: closed form and autodiff differ by %g\n", difference);
    return 3;
  }
  std::fprintf(stderr, "closed form and autodiff agree within %.1e\n", difference);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
