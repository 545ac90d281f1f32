// The small fits that run very often or have own elimination, as in the product, and what Ceres takes for the
// same residuals and closed-form Jacobians: as one residual block through SmallFit, by ceres::TinySolver, or
// by Schur elimination. TriangulationOwn holds the start, the choice of inliers and the covariance as well;
// Ceres' rows are the refinement alone. Before any timing the results must agree.
#include <benchmark/benchmark.h>
#include <ceres/sized_cost_function.h>
#include <ceres/solver.h>
#include <ceres/tiny_solver.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <numeric>

#include "mlic_core/camera/two_view/epipolar_refinement.h"
#include "mlic_core/camera/two_view/triangulation.h"
#include "mlic_core/common/random.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/imu/angular_rate_alignment.h"
#include "mlic_core/imu/gravity_lever_arm.h"
#include "mlic_core/solver/small_fit.h"
#include "support/test_motion.h"

namespace mlic {
namespace {

using Eigen::Vector3d;
using RowMajor3 = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

Vector3d RandomVector(Random* random) { return {random->Normal(), random->Normal(), random->Normal()}; }

std::vector<BearingObservation> MakeTrack(int observations) {
  Random random(7);
  const Vector3d point(2.0, -1.0, 9.0);
  std::vector<BearingObservation> track;
  for (int i = 0; i < observations; ++i) {
    BearingObservation o;
    o.centre = Vector3d(0.2 * i, 0.05 * random.Normal(), 0.05 * random.Normal());
    o.direction = ((point - o.centre).normalized() + o.sigma * RandomVector(&random)).normalized();
    track.push_back(o);
  }
  return track;
}

// As in triangulation.cc: (I - d d^T) p / |p| / sigma.
void BearingResidual(const BearingObservation& o, const Vector3d& point, Vector3d* r, Eigen::Matrix3d* J) {
  const Vector3d ray = point - o.centre;
  const double inverse = 1.0 / ray.norm();
  const Vector3d unit = ray * inverse;
  const Vector3d& d = o.direction;
  *r = (unit - d * d.dot(unit)) / o.sigma;
  if (J == nullptr) return;
  const Eigen::Matrix3d to_unit = (Eigen::Matrix3d::Identity() - unit * unit.transpose()) * inverse;
  *J = (to_unit - d * (d.transpose() * to_unit)) / o.sigma;
}

struct TinyTriangulation {
  using Scalar = double;
  enum { NUM_RESIDUALS = Eigen::Dynamic, NUM_PARAMETERS = 3 };
  const std::vector<BearingObservation>& track;

  int NumResiduals() const { return 3 * static_cast<int>(track.size()); }
  bool operator()(const double* point, double* r, double* J) const {
    for (std::size_t i = 0; i < track.size(); ++i) {
      Vector3d error;
      Eigen::Matrix3d own;
      BearingResidual(track[i], Vector3d(point), &error, J != nullptr ? &own : nullptr);
      Eigen::Map<Vector3d>(r + 3 * i, 3) = error;
      if (J == nullptr) continue;
      Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, 3>> to(J, NumResiduals(), 3);
      to.middleRows<3>(3 * static_cast<Eigen::Index>(i)) = own;
    }
    return true;
  }
};

Vector3d ByTinySolver(const std::vector<BearingObservation>& track, Vector3d point) {
  const TinyTriangulation function{track};
  ceres::TinySolver<TinyTriangulation> solver;
  solver.Solve(function, &point);
  return point;
}

Vector3d BySmallFit(const std::vector<BearingObservation>& track, Vector3d point) {
  SmallFit fit;
  const auto residual = [&](double const* const* at, double* r, double** jacobians) {
    const bool wanted = jacobians != nullptr && jacobians[0] != nullptr;
    for (std::size_t i = 0; i < track.size(); ++i) {
      Vector3d error;
      Eigen::Matrix3d own;
      BearingResidual(track[i], Vector3d(at[0]), &error, wanted ? &own : nullptr);
      Eigen::Map<Vector3d>(r + 3 * i, 3) = error;
      if (wanted) Eigen::Map<RowMajor3>(jacobians[0] + 9 * i, 3, 3) = own;
    }
    return true;
  };
  fit.Add(3 * static_cast<int>(track.size()), residual, {{point.data(), 3}});
  fit.Solve(30);
  return point;
}

// Where NearestToRays would start.
const Vector3d kStart(2.05, -1.03, 9.2);

void TriangulationOwn(benchmark::State& state) {
  const auto track = MakeTrack(static_cast<int>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(TriangulatePoint(track));
}
void TriangulationSmallFit(benchmark::State& state) {
  const auto track = MakeTrack(static_cast<int>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(BySmallFit(track, kStart));
}
void TriangulationTinySolver(benchmark::State& state) {
  const auto track = MakeTrack(static_cast<int>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(ByTinySolver(track, kStart));
}

struct Matches {
  RelativePose start;
  std::vector<Vector3d> a, b;
  std::vector<bool> used;
};

Matches MakeMatches(int count) {
  Random random(3);
  const Eigen::Matrix3d R = ExpMatrix(Vector3d(0.1, -0.2, 0.15));
  const Vector3d t = Vector3d(1.0, 0.3, -0.2).normalized();
  Matches matches;
  for (int i = 0; i < count; ++i) {
    const Vector3d bearing = Vector3d(random.Uniform(-1, 1), random.Uniform(-1, 1), 1.0).normalized();
    const Vector3d in_b = R * (random.Uniform(4, 30) * bearing) + t;
    matches.a.push_back((bearing + 1e-3 * RandomVector(&random)).normalized());
    matches.b.push_back((in_b.normalized() + 1e-3 * RandomVector(&random)).normalized());
  }
  matches.used.assign(count, true);
  // A five-point sample's own error.
  matches.start = {ExpMatrix(Vector3d(0.005, -0.004, 0.006)) * R,
                   (t + Vector3d(0.0, 0.05, 0.04)).normalized()};
  return matches;
}

// Sampson's error as in epipolar_refinement.cc, with its derivatives to a left perturbation and to t.
double EpipolarResidual(const Eigen::Matrix3d& R, const Vector3d& t, const Vector3d& a, const Vector3d& b,
                        Vector3d* J_R, Vector3d* J_t) {
  const Vector3d q = R * a;
  const Vector3d q_b = q.cross(b), q_t = q.cross(t);
  const double e = t.dot(q_b), tq = t.dot(q), tb = t.dot(b);
  const double D = std::max(1e-12, 2.0 - tq * tq - tb * tb - 2.0 * e * e);
  const double root = 1.0 / std::sqrt(D), slope = -0.5 * e / D;
  const Vector3d e_R = q.cross(b.cross(t));
  *J_R = root * (e_R + slope * (-2.0 * tq * q_t - 4.0 * e * e_R));
  *J_t = root * (q_b + slope * (-2.0 * (tq * q + tb * b) - 4.0 * e * q_b));
  return e * root;
}

// The direction of t by its two steps in the tangent plane of the start.
struct Direction {
  Vector3d start, first, second;

  explicit Direction(const Vector3d& t) : start(t), first(t.unitOrthogonal()), second(t.cross(first)) {}
  Vector3d At(const double* step, Eigen::Matrix<double, 3, 2>* J) const {
    const Vector3d sum = start + step[0] * first + step[1] * second;
    const double norm = sum.norm();
    const Vector3d t = sum / norm;
    const Eigen::Matrix3d to_unit = (Eigen::Matrix3d::Identity() - t * t.transpose()) / norm;
    J->col(0) = to_unit * first;
    J->col(1) = to_unit * second;
    return t;
  }
};

RelativePose EpipolarBySmallFit(const Matches& matches) {
  Eigen::Quaterniond q(matches.start.R);
  double step[2] = {0.0, 0.0};
  const Direction direction(matches.start.t);
  const auto residual = [&](double const* const* at, double* r, double** jacobians) {
    const Eigen::Quaterniond rotation(at[0]);
    const Eigen::Matrix3d R = rotation.toRotationMatrix();
    const Eigen::Matrix<double, 3, 4> to_quaternion = LeftPerturbationJacobian(rotation);
    Eigen::Matrix<double, 3, 2> tangents;
    const Vector3d t = direction.At(at[1], &tangents);
    for (std::size_t i = 0; i < matches.a.size(); ++i) {
      Vector3d J_R, J_t;
      r[i] = EpipolarResidual(R, t, matches.a[i], matches.b[i], &J_R, &J_t);
      if (jacobians == nullptr) continue;
      Eigen::Map<Eigen::RowVector4d>(jacobians[0] + 4 * i, 4) = J_R.transpose() * to_quaternion;
      Eigen::Map<Eigen::RowVector2d>(jacobians[1] + 2 * i, 2) = J_t.transpose() * tangents;
    }
    return true;
  };
  SmallFit fit;
  fit.Add(static_cast<int>(matches.a.size()), residual, {{q.coeffs().data(), 4}, {step, 2}});
  fit.SetRotation(&q);
  fit.Solve(20);
  Eigen::Matrix<double, 3, 2> tangents;
  return {q.toRotationMatrix(), direction.At(step, &tangents)};
}

void EpipolarOwn(benchmark::State& state) {
  const Matches m = MakeMatches(static_cast<int>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(RefineRelativePose(m.start, m.a, m.b, m.used));
}
void EpipolarSmallFit(benchmark::State& state) {
  const Matches m = MakeMatches(static_cast<int>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(EpipolarBySmallFit(m));
}

// One pose of a drive cut into segments: kShared unknowns of the drive, kLocal of its segment, linear.
template <int kShared, int kLocal>
class ArrowRow : public ceres::SizedCostFunction<3, kShared, kLocal> {
 public:
  explicit ArrowRow(Random* random) {
    for (double& v : shared_) v = random->Normal();
    for (double& v : local_) v = random->Normal();
    for (double& v : value_) v = random->Normal();
  }
  bool Evaluate(double const* const* at, double* r, double** jacobians) const override {
    for (int i = 0; i < 3; ++i) {
      r[i] = value_[i] + std::inner_product(at[0], at[0] + kShared, shared_ + kShared * i, 0.0) +
             std::inner_product(at[1], at[1] + kLocal, local_ + kLocal * i, 0.0);
    }
    if (jacobians != nullptr && jacobians[0] != nullptr) std::copy_n(shared_, 3 * kShared, jacobians[0]);
    if (jacobians != nullptr && jacobians[1] != nullptr) std::copy_n(local_, 3 * kLocal, jacobians[1]);
    return true;
  }

 private:
  double shared_[3 * kShared], local_[3 * kLocal], value_[3];
};

constexpr double kDrive = 60.0, kSegment = 2.0;  // s
constexpr int kPosesPerSegment = 20;             // at 10 Hz

// One re-weighted round of a fit of that form, without the integration of the IMU that each needs besides.
template <int kShared, int kLocal>
void RoundByCeres(benchmark::State& state) {
  constexpr int kSegments = static_cast<int>(kDrive / kSegment);
  for (auto _ : state) {
    Random random(1);
    double shared[kShared] = {};
    std::vector<std::array<double, kLocal>> local(kSegments);
    ceres::Problem problem;
    ceres::Solver::Options options;
    options.linear_solver_ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    for (auto& block : local) {
      block.fill(0.0);
      for (int k = 0; k < kPosesPerSegment; ++k)
        problem.AddResidualBlock(new ArrowRow<kShared, kLocal>(&random), nullptr, shared, block.data());
      options.linear_solver_ordering->AddElementToGroup(block.data(), 0);
    }
    options.linear_solver_ordering->AddElementToGroup(shared, 1);
    options.linear_solver_type = ceres::DENSE_SCHUR;
    options.max_num_iterations = 1;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    benchmark::DoNotOptimize(summary.final_cost);
  }
}
void GravityLeverArmOwn(benchmark::State& state) {
  const test::Rig rig;
  const auto recording =
      test::Record(test::HandHeld(), rig, {2e-4, 2e-3, 0.01, 0.1 * M_PI / 180.0}, 400.0, kDrive, 1);
  for (auto _ : state) {
    benchmark::DoNotOptimize(SolveGravityLeverArm(recording.imu, recording.poses, rig.T_imu_lidar.rotation,
                                                  rig.time_offset, rig.gyroscope_bias, std::nullopt));
  }
}

void AngularRatesOwn(benchmark::State& state) {
  const auto recording =
      test::Record(test::HandHeld(), test::Rig(), {2e-4, 2e-3, 0.01, 0.1 * M_PI / 180.0}, 400.0, kDrive, 1);
  for (auto _ : state) {
    benchmark::DoNotOptimize(AlignAngularRates(recording.imu, recording.poses, std::nullopt));
  }
}

BENCHMARK(GravityLeverArmOwn)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(RoundByCeres, 12, 9)->Unit(benchmark::kMillisecond);
BENCHMARK(AngularRatesOwn)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(RoundByCeres, 7, 3)->Unit(benchmark::kMillisecond);
BENCHMARK(TriangulationOwn)->Arg(4)->Arg(12);
BENCHMARK(TriangulationTinySolver)->Arg(4)->Arg(12);
BENCHMARK(TriangulationSmallFit)->Arg(4)->Arg(12);
BENCHMARK(EpipolarOwn)->Arg(100)->Arg(1000);
BENCHMARK(EpipolarSmallFit)->Arg(100)->Arg(1000);

void CheckAgreement() {
  const auto track = MakeTrack(12);
  const Vector3d own = TriangulatePoint(track)->position;
  const double by_fit = (BySmallFit(track, kStart) - own).norm(),
               tiny = (ByTinySolver(track, kStart) - own).norm();
  const Matches m = MakeMatches(300);
  const RelativePose a = RefineRelativePose(m.start, m.a, m.b, m.used), b = EpipolarBySmallFit(m);
  const double pose = (a.R - b.R).norm() + (a.t - b.t).norm();
  if (by_fit < 1e-6 && tiny < 1e-4 && pose < 1e-5) return;
  std::fprintf(stderr, "own fits and Ceres do not agree: %g m, %g m, %g\n", by_fit, tiny, pose);
  std::exit(1);
}

}  // namespace
}  // namespace mlic

int main(int argc, char** argv) {
  mlic::CheckAgreement();
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
