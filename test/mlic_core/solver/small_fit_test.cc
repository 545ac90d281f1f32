#include "mlic_core/solver/small_fit.h"

#include <ceres/autodiff_cost_function.h>
#include <gtest/gtest.h>

#include <cmath>

#include "mlic_core/common/random.h"
#include "mlic_core/geometry/rigid_transform.h"
#include "mlic_core/geometry/so3.h"

namespace mlic::small_fit_test {
namespace {

using Eigen::Vector3d;

Vector3d RandomVector(Random* random) { return {random->Normal(), random->Normal(), random->Normal()}; }

// Points seen in two frames: b = T * a + noise.
struct Pairs {
  RigidTransform T;
  std::vector<Vector3d> a, b;
};

Pairs MakePairs(int count, double sigma, std::uint64_t seed) {
  Random random(seed);
  Pairs pairs;
  pairs.T = {ExpQuaternion(RandomVector(&random)), RandomVector(&random)};
  for (int i = 0; i < count; ++i) {
    pairs.a.push_back(3.0 * RandomVector(&random));
    pairs.b.push_back(pairs.T * pairs.a.back() + sigma * RandomVector(&random));
  }
  return pairs;
}

void AddPair(const Vector3d& a, const Vector3d& b, double sigma, RigidTransform* T, double huber,
             SmallFit* fit) {
  const auto residual = [a, b, sigma](double const* const* blocks, double* r, double** jacobians) {
    const Eigen::Quaterniond q{Eigen::Map<const Eigen::Vector4d>(blocks[0])};
    const Vector3d turned = q * a;
    Eigen::Map<Vector3d>(r, 3) = (turned + Eigen::Map<const Vector3d>(blocks[1]) - b) / sigma;
    StoreJacobian(-Hat(turned) / sigma * LeftPerturbationJacobian(q), 0, jacobians);
    StoreJacobian(Eigen::Matrix3d::Identity() / sigma, 1, jacobians);
    return true;
  };
  fit->Add(3, residual, {{T->rotation.coeffs().data(), 4}, {T->translation.data(), 3}}, huber);
}

struct AutodiffPair {
  Vector3d a, b;

  template <typename T>
  bool operator()(const T* rotation, const T* translation, T* r) const {
    const Eigen::Quaternion<T> q(rotation[3], rotation[0], rotation[1], rotation[2]);
    const Eigen::Matrix<T, 3, 1> moved = q * a.cast<T>();
    for (int i = 0; i < 3; ++i) r[i] = moved[i] + translation[i] - T(b[i]);
    return true;
  }
};

double PoseError(const RigidTransform& a, const RigidTransform& b) {
  return AngleBetween(a.rotation, b.rotation) + (a.translation - b.translation).norm();
}

TEST(SmallFit, WithoutNoiseAPoseComesBackFromFarAway) {
  const Pairs pairs = MakePairs(30, 0.0, 1);
  RigidTransform T;
  SmallFit fit;
  for (std::size_t i = 0; i < pairs.a.size(); ++i) AddPair(pairs.a[i], pairs.b[i], 1.0, &T, 0.0, &fit);
  fit.SetRotation(&T.rotation);
  const SmallFitSummary summary = fit.Solve(50);
  EXPECT_TRUE(summary.usable && summary.converged);
  EXPECT_LT(summary.cost, 1e-20);
  EXPECT_LT(PoseError(T, pairs.T), 1e-10);
  EXPECT_NEAR(T.rotation.norm(), 1.0, 1e-12);
}

TEST(SmallFit, ErrorsAreAsTheInformationSays) {
  constexpr double kSigma = 0.02;
  constexpr int kRuns = 200;
  double sum = 0.0;
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    const Pairs pairs = MakePairs(20, kSigma, seed);
    RigidTransform T;
    SmallFit fit;
    for (std::size_t i = 0; i < pairs.a.size(); ++i) AddPair(pairs.a[i], pairs.b[i], kSigma, &T, 0.0, &fit);
    fit.SetRotation(&T.rotation);
    ASSERT_TRUE(fit.Solve(50).converged);
    Eigen::Matrix<double, 6, 1> error;
    error << Log(Eigen::Quaterniond(pairs.T.rotation * T.rotation.conjugate())),
        pairs.T.translation - T.translation;
    sum += error.dot(fit.Information({T.rotation.coeffs().data(), T.translation.data()}) * error);
  }
  // Chi-squared with 6 degrees of freedom: the mean of 200 draws has a standard deviation of 0.25.
  EXPECT_NEAR(sum / kRuns, 6.0, 1.0);
}

TEST(SmallFit, ALossKeepsOutliersFromTheResult) {
  Pairs pairs = MakePairs(40, 0.01, 3);
  for (int i = 0; i < 8; ++i) pairs.b[i] += Vector3d(5.0, -4.0, 3.0);
  RigidTransform T;
  SmallFit fit;
  for (std::size_t i = 0; i < pairs.a.size(); ++i) AddPair(pairs.a[i], pairs.b[i], 0.01, &T, 1.0, &fit);
  fit.SetRotation(&T.rotation);
  EXPECT_TRUE(fit.Solve(50).usable);
  EXPECT_LT(PoseError(T, pairs.T), 0.02);
}

TEST(SmallFit, AutodiffAndClosedFormsReachTheSamePose) {
  const Pairs pairs = MakePairs(20, 0.1, 4);
  RigidTransform closed, autodiff;
  SmallFit fit, fit_autodiff;
  for (std::size_t i = 0; i < pairs.a.size(); ++i) {
    AddPair(pairs.a[i], pairs.b[i], 1.0, &closed, 0.0, &fit);
    fit_autodiff.Add(
        new ceres::AutoDiffCostFunction<AutodiffPair, 3, 4, 3>(new AutodiffPair{pairs.a[i], pairs.b[i]}),
        {autodiff.rotation.coeffs().data(), autodiff.translation.data()});
  }
  fit.SetRotation(&closed.rotation);
  fit_autodiff.SetRotation(&autodiff.rotation);
  fit.Solve(50);
  fit_autodiff.Solve(50);
  EXPECT_LT(PoseError(closed, autodiff), 1e-9);
  const std::vector<double*> blocks = {closed.rotation.coeffs().data(), closed.translation.data()};
  const std::vector<double*> same = {autodiff.rotation.coeffs().data(), autodiff.translation.data()};
  EXPECT_LT((fit.Information(blocks) - fit_autodiff.Information(same)).norm(), 1e-6);
}

TEST(SmallFit, AResidualThatDoesNotExistAtTheStartIsReported) {
  double x = -1.0;
  SmallFit fit;
  fit.Add(1,
          [](double const* const* blocks, double* r, double** jacobians) {
            r[0] = std::sqrt(blocks[0][0]);
            if (jacobians != nullptr && jacobians[0] != nullptr) jacobians[0][0] = 0.5 / r[0];
            return blocks[0][0] > 0.0;
          },
          {{&x, 1}});
  EXPECT_FALSE(fit.Solve(10).usable);
  EXPECT_EQ(x, -1.0);
}

TEST(SmallFit, SameInputSameBytes) {
  RigidTransform result[2];
  for (RigidTransform& T : result) {
    const Pairs pairs = MakePairs(25, 0.1, 5);
    SmallFit fit;
    for (std::size_t i = 0; i < pairs.a.size(); ++i) AddPair(pairs.a[i], pairs.b[i], 1.0, &T, 0.0, &fit);
    fit.SetRotation(&T.rotation);
    fit.Solve(50);
  }
  EXPECT_EQ(result[0].rotation.coeffs(), result[1].rotation.coeffs());
  EXPECT_EQ(result[0].translation, result[1].translation);
}

}  // namespace
}  // namespace mlic::small_fit_test
