// Time of a spline residual with all its Jacobians on one core: closed form (factors/) against Ceres'
// automatic differentiation of the same residual in the same run. Before any timing both must agree on value
// and derivative.
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdio>
#include <memory>
#include <vector>

#include "autodiff_residuals.h"
#include "mlic_core/common/random.h"
#include "mlic_core/factors/imu_residual.h"
#include "mlic_core/factors/point_to_plane.h"

namespace mlic {
namespace {

constexpr int kSamples =
    512;  // at random times, so that neither caches nor branches see the same sample twice
constexpr double kRotationSpacing = 0.02, kPositionSpacing = 0.05;

Eigen::Vector3d RandomVector(Random& random) { return {random.Normal(), random.Normal(), random.Normal()}; }

SplitSpline MakeTrajectory() {
  Random random(1);
  SplitSpline trajectory;
  const UniformKnots rotation_knots = UniformKnots::Covering(0.0, 10.0, kRotationSpacing);
  std::vector<Eigen::Quaterniond> rotations(1, Eigen::Quaterniond::Identity());
  while (static_cast<int>(rotations.size()) < rotation_knots.count)
    rotations.push_back((rotations.back() * ExpQuaternion(0.02 * RandomVector(random))).normalized());
  trajectory.rotation = So3Spline(rotation_knots, rotations);
  const UniformKnots position_knots = UniformKnots::Covering(0.0, 10.0, kPositionSpacing);
  std::vector<Eigen::Vector3d> positions(1, Eigen::Vector3d::Zero());
  while (static_cast<int>(positions.size()) < position_knots.count)
    positions.push_back(positions.back() + 0.05 * RandomVector(random));
  trajectory.position = PositionSpline(position_knots, positions);
  return trajectory;
}

// What both ways of computing are given.
struct Setup {
  SplitSpline trajectory = MakeTrajectory();
  Eigen::Vector3d gravity{0.0, 0.0, -9.81};
  ImuCalibration imu;
  std::vector<ImuSample> samples;
  std::vector<Eigen::Vector3d> points;
  std::vector<double> times;
  PointToPlane plane;
  Eigen::Quaterniond q_imu_lidar = ExpQuaternion({0.3, -0.2, 0.5});
  PointToPlane::Extrinsic extrinsic{q_imu_lidar.toRotationMatrix(), Eigen::Vector3d(0.1, 1.5, -0.2)};

  Setup() {
    plane.normal = Eigen::Vector3d(0.2, -0.3, 0.9).normalized();
    plane.tangent_u = plane.normal.unitOrthogonal();
    plane.tangent_v = plane.normal.cross(plane.tangent_u);
    plane.anchor = Eigen::Vector3d(3.0, 4.0, 5.0);
    plane.offset = 0.01;
    Random random(2);
    while (static_cast<int>(points.size()) < kSamples) {
      const double t = random.Uniform(0.5, 9.5);
      Eigen::Vector3d point = 10.0 * RandomVector(random);
      const Eigen::Vector3d beam =
          trajectory.rotation.Evaluate(RotationBasis(t)).rotation * (q_imu_lidar * point.normalized());
      // Planes are seen from their front, and not edge on.
      if (std::abs(plane.normal.dot(beam)) < 0.3) continue;
      if (plane.normal.dot(beam) > 0.0) point = -point;
      times.push_back(t);
      samples.push_back({t, RandomVector(random), RandomVector(random)});
      points.push_back(point);
    }
  }

  SplineBasis RotationBasis(double t) const { return SplineBasis(trajectory.rotation.knots(), t); }
  SplineBasis PositionBasis(double t) const { return SplineBasis(trajectory.position.knots(), t); }
};

// A cost function of Ceres with its parameter blocks and room for residual and Jacobians.
struct AutodiffCall {
  std::unique_ptr<ceres::CostFunction> cost;
  std::vector<const double*> parameters;
  std::vector<double> tail;  // parameters that are not control points
  std::vector<std::vector<double>> storage;
  std::vector<double*> jacobians;
  Eigen::Matrix<double, 6, 1> residual;

  void Finish() {
    for (const int size : cost->parameter_block_sizes()) storage.emplace_back(size * cost->num_residuals());
    for (std::vector<double>& block : storage) jacobians.push_back(block.data());
  }
  void Evaluate() { cost->Evaluate(parameters.data(), residual.data(), jacobians.data()); }
};

void AddControlPoints(const Setup& setup, const SplineBasis& rotation, const SplineBasis& position,
                      AutodiffCall* call) {
  for (int j = 0; j < 4; ++j)
    call->parameters.push_back(
        setup.trajectory.rotation.control_points()[rotation.first + j].coeffs().data());
  for (int j = 0; j < 4; ++j)
    call->parameters.push_back(setup.trajectory.position.control_points()[position.first + j].data());
}

std::vector<AutodiffCall> ImuCalls(const Setup& setup) {
  std::vector<AutodiffCall> calls(kSamples);
  for (int i = 0; i < kSamples; ++i) {
    const ImuSample& sample = setup.samples[i];
    const SplineBasis rotation = setup.RotationBasis(sample.time),
                      position = setup.PositionBasis(sample.time);
    AutodiffCall& call = calls[i];
    call.cost.reset(ImuAutodiff::Create(
        {rotation, position, sample.angular_velocity, sample.specific_force, setup.gravity}));
    AddControlPoints(setup, rotation, position, &call);
    call.tail.assign(6, 0.0);
    call.parameters.push_back(call.tail.data());
    call.parameters.push_back(call.tail.data() + 3);
    call.Finish();
  }
  return calls;
}

std::vector<AutodiffCall> PointCalls(const Setup& setup) {
  std::vector<AutodiffCall> calls(kSamples);
  for (int i = 0; i < kSamples; ++i) {
    const double t = setup.times[i];
    const SplineBasis rotation = setup.RotationBasis(t), position = setup.PositionBasis(t);
    const auto normalised = [&](const UniformKnots& knots, int first) {
      return (t - knots.start) / knots.spacing - first;
    };
    AutodiffCall& call = calls[i];
    call.cost.reset(PointToPlaneAutodiff::Create(
        {normalised(setup.trajectory.rotation.knots(), rotation.first),
         normalised(setup.trajectory.position.knots(), position.first),
         setup.trajectory.rotation.knots().spacing, setup.trajectory.position.knots().spacing,
         setup.points[i], setup.plane.normal, setup.plane.tangent_u, setup.plane.tangent_v,
         setup.plane.anchor}));
    AddControlPoints(setup, rotation, position, &call);
    const Eigen::Vector4d q = setup.q_imu_lidar.coeffs();
    const Eigen::Vector3d& p = setup.extrinsic.p_imu_lidar;
    call.tail = {q[0], q[1], q[2], q[3], p[0], p[1], p[2], 0.0, 0.0, 0.0, setup.plane.offset};
    call.parameters.push_back(call.tail.data());
    call.Finish();
  }
  return calls;
}

Eigen::Matrix<double, 6, 1> ClosedImu(const Setup& setup, int i, ImuResidual::Jacobian* jacobian) {
  const ImuSample& sample = setup.samples[i];
  const ImuBases bases(setup.trajectory, sample.time, setup.imu.accelerometer_lag);
  return ImuResidual::Evaluate(setup.trajectory, bases, setup.imu, setup.gravity, sample, jacobian);
}

double ClosedPoint(const Setup& setup, int i, double* row) {
  const double t = setup.times[i];
  return setup.plane.Evaluate(setup.trajectory, setup.RotationBasis(t), setup.PositionBasis(t),
                              setup.extrinsic, setup.points[i], row);
}

// Largest difference between both ways, of values and of the derivatives with the same parameters.
double LargestDifference(const Setup& setup) {
  double largest = 0.0;
  std::vector<AutodiffCall> imu = ImuCalls(setup), point = PointCalls(setup);
  for (int i = 0; i < kSamples; ++i) {
    ImuResidual::Jacobian jacobian;
    imu[i].Evaluate();
    largest = std::max(largest, (ClosedImu(setup, i, &jacobian) - imu[i].residual).cwiseAbs().maxCoeff());
    for (int j = 0; j < 4; ++j) {
      const Eigen::Map<const Eigen::Matrix<double, 6, 3, Eigen::RowMajor>> block(imu[i].jacobians[4 + j]);
      const Eigen::Matrix<double, 6, 3> closed =
          jacobian.middleRows<3>(ImuResidual::kPosition + 3 * j).transpose();
      largest = std::max(largest, 1e-3 * (block - closed).cwiseAbs().maxCoeff());  // up to 1/spacing^2 large
    }
    double row[PointToPlane::kColumns];
    point[i].Evaluate();
    largest = std::max(largest, std::abs(ClosedPoint(setup, i, row) - point[i].residual[0]));
    const double* last = point[i].jacobians[8];
    for (int k = 0; k < 3; ++k)
      largest = std::max(largest, std::abs(last[4 + k] - row[PointToPlane::kExtrinsic + 3 + k]));
    largest = std::max(largest, std::abs(last[7] - row[PointToPlane::kTimeOffset]));
    for (int k = 0; k < 3; ++k)
      largest = std::max(largest, std::abs(last[8 + k] - row[PointToPlane::kPlane + k]));
  }
  return largest;
}

void ImuClosedForm(benchmark::State& state) {
  const Setup setup;
  ImuResidual::Jacobian jacobian;
  int i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(ClosedImu(setup, i++ % kSamples, &jacobian));
    benchmark::DoNotOptimize(jacobian.data());
    benchmark::ClobberMemory();
  }
}
BENCHMARK(ImuClosedForm);

void ImuCeresAutodiff(benchmark::State& state) {
  const Setup setup;
  std::vector<AutodiffCall> calls = ImuCalls(setup);
  int i = 0;
  for (auto _ : state) {
    calls[i++ % kSamples].Evaluate();
    benchmark::ClobberMemory();
  }
}
BENCHMARK(ImuCeresAutodiff);

void PointToPlaneClosedForm(benchmark::State& state) {
  const Setup setup;
  double row[PointToPlane::kColumns];
  int i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(ClosedPoint(setup, i++ % kSamples, row));
    benchmark::DoNotOptimize(&row[0]);
    benchmark::ClobberMemory();
  }
}
BENCHMARK(PointToPlaneClosedForm);

void PointToPlaneCeresAutodiff(benchmark::State& state) {
  const Setup setup;
  std::vector<AutodiffCall> calls = PointCalls(setup);
  int i = 0;
  for (auto _ : state) {
    calls[i++ % kSamples].Evaluate();
    benchmark::ClobberMemory();
  }
}
BENCHMARK(PointToPlaneCeresAutodiff);

// What the closed form computes once after each change of the control points, for one of them.
void PreparationOfOneControlPoint(benchmark::State& state) {
  Setup setup;
  const int count = setup.trajectory.rotation.knots().count;
  std::vector<int> offsets(count);
  for (int j = 0; j < count; ++j) offsets[j] = 3 * j;
  const Eigen::VectorXd delta = Eigen::VectorXd::Zero(3 * count);
  while (state.KeepRunningBatch(count)) setup.trajectory.rotation.Update(delta, offsets);
}
BENCHMARK(PreparationOfOneControlPoint);

}  // namespace
}  // namespace mlic

int main(int argc, char** argv) {
  const double difference = mlic::LargestDifference(mlic::Setup());
  if (!(difference < 1e-8)) {
    std::fprintf(stderr, "spline_benchmark: closed form and autodiff differ by %g\n", difference);
    return 3;
  }
  std::fprintf(stderr, "closed form and autodiff agree within %.1e\n", difference);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
