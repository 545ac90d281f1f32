#include "mlic_core/camera/two_view/triangulation.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "mlic_core/common/count_true.h"
#include "mlic_core/geometry/symmetric_matrix.h"

namespace mlic {
namespace {

// Pairs of rays tried as a start where not all observations agree.
constexpr int kMostPairs = 60;  // from: guard, time

struct NormalEquations {
  Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
  Eigen::Vector3d g = Eigen::Vector3d::Zero();
  double cost = 0.0;
};

// The whitened angle between observation and point: its two components in the tangent plane of the
// observation, so their sine; a point behind counts with its full angle.
double SquaredError(const BearingObservation& observation, const Eigen::Vector3d& point) {
  const Eigen::Vector3d ray = point - observation.centre;
  const double range = ray.norm();
  if (!(range > 0.0)) return 1e300;
  const double cosine = observation.direction.dot(ray) / range;
  const double sine = observation.direction.cross(ray).norm() / range;
  const double error = cosine > 0.0 ? sine : std::atan2(sine, cosine);
  return error * error / (observation.sigma * observation.sigma);
}

// Residual of an observation: (I - d d^T) p / |p| / sigma, whose two tangent components are the errors; the
// third adds nothing.
NormalEquations Build(const std::vector<BearingObservation>& observations, const std::vector<bool>& used,
                      const Eigen::Vector3d& point) {
  NormalEquations system;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    if (!used[i]) continue;
    const Eigen::Vector3d ray = point - observations[i].centre;
    const double inverse = 1.0 / ray.norm();
    const Eigen::Vector3d unit = ray * inverse;
    const Eigen::Vector3d& d = observations[i].direction;
    const Eigen::Vector3d error = (unit - d * d.dot(unit)) / observations[i].sigma;
    const Eigen::Matrix3d to_unit = (Eigen::Matrix3d::Identity() - unit * unit.transpose()) * inverse;
    const Eigen::Matrix3d J = (to_unit - d * (d.transpose() * to_unit)) / observations[i].sigma;
    system.H.noalias() += J.transpose() * J;
    system.g.noalias() += J.transpose() * error;
    system.cost += error.squaredNorm();
  }
  return system;
}

// The point nearest to all rays, distances weighted by the inverse range in the second and third round, which
// makes them angles.
bool NearestToRays(const std::vector<BearingObservation>& observations, const std::vector<bool>& used,
                   Eigen::Vector3d* point) {
  for (int round = 0; round < 3; ++round) {
    Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
    Eigen::Vector3d b = Eigen::Vector3d::Zero();
    double weights = 0.0;
    for (std::size_t i = 0; i < observations.size(); ++i) {
      if (!used[i]) continue;
      const double range = round == 0 ? 1.0 : std::max(1e-3, (*point - observations[i].centre).norm());
      const double weight = 1.0 / (range * range * observations[i].sigma * observations[i].sigma);
      const Eigen::Matrix3d across =
          Eigen::Matrix3d::Identity() - observations[i].direction * observations[i].direction.transpose();
      A += weight * across;
      b += weight * (across * observations[i].centre);
      weights += weight;
    }
    // Relative to the weights the determinant is the squared sine of the rays' angle.
    if (!(A.determinant() > 1e-12 * weights * weights * weights)) return false;
    *point = SolveSymmetric3(A, b);
    if (!point->allFinite()) return false;
  }
  return true;
}

// Gauss-Newton with damping. False where the rays do not meet in front of the cameras.
bool Refine(const std::vector<BearingObservation>& observations, const std::vector<bool>& used,
            Eigen::Vector3d* point, NormalEquations* system) {
  *system = Build(observations, used, *point);
  double damping = 1e-6;
  for (int iteration = 0; iteration < 30 && damping < 1e6; ++iteration) {
    Eigen::Matrix3d H = system->H;
    H.diagonal() *= 1.0 + damping;
    const Eigen::Vector3d step = -SolveSymmetric3(H, system->g);
    if (!step.allFinite()) return false;
    const NormalEquations trial = Build(observations, used, *point + step);
    if (trial.cost < system->cost) {
      const bool done = system->cost - trial.cost < 1e-12 * (1.0 + system->cost);
      *point += step;
      *system = trial;
      damping = std::max(1e-12, 0.1 * damping);
      if (done) break;
    } else {
      if (step.norm() < 1e-12 * (1.0 + point->norm())) break;
      damping *= 10.0;
    }
  }
  return point->allFinite();
}

std::vector<bool> Agreeing(const std::vector<BearingObservation>& observations, const Eigen::Vector3d& point,
                           double largest_error, double* cost) {
  std::vector<bool> agrees(observations.size());
  const double limit = largest_error * largest_error;
  *cost = 0.0;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const double squared = SquaredError(observations[i], point);
    agrees[i] = squared <= limit;
    *cost += std::min(squared, limit);
  }
  return agrees;
}

// The pair of rays whose point agrees with the most others.
std::vector<bool> BestPair(const std::vector<BearingObservation>& observations, double largest_error) {
  const int count = static_cast<int>(observations.size());
  const int pairs = count * (count - 1) / 2;
  const int stride = std::max(1, (pairs + kMostPairs - 1) / kMostPairs);
  std::vector<bool> best(count, false), pair(count, false);
  double least = 1e300;
  int index = 0;
  // Widely separated observations first, so that those kept by the stride have parallax.
  for (int gap = count - 1; gap > 0; --gap) {
    for (int i = 0; i + gap < count; ++i, ++index) {
      if (index % stride != 0) continue;
      pair[i] = pair[i + gap] = true;
      Eigen::Vector3d point;
      if (NearestToRays(observations, pair, &point)) {
        double cost;
        std::vector<bool> agrees = Agreeing(observations, point, largest_error, &cost);
        if (cost < least) {
          least = cost;
          best = agrees;
        }
      }
      pair[i] = pair[i + gap] = false;
    }
  }
  return best;
}

double LargestParallax(const std::vector<BearingObservation>& observations, const std::vector<bool>& used,
                       const Eigen::Vector3d& point) {
  double largest = 0.0;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    if (!used[i]) continue;
    const Eigen::Vector3d u = (observations[i].centre - point).normalized();
    for (std::size_t j = i + 1; j < observations.size(); ++j) {
      if (!used[j]) continue;
      const Eigen::Vector3d v = (observations[j].centre - point).normalized();
      largest = std::max(largest, std::atan2(u.cross(v).norm(), u.dot(v)));
    }
  }
  return largest;
}

}  // namespace

std::optional<TriangulatedPoint> TriangulatePoint(const std::vector<BearingObservation>& observations,
                                                  const TriangulationOptions& options) {
  const int count = static_cast<int>(observations.size());
  if (count < 2) return std::nullopt;
  TriangulatedPoint result;
  NormalEquations system;
  double cost;
  const auto solve = [&](const std::vector<bool>& used) {
    return NearestToRays(observations, used, &result.position) &&
           Refine(observations, used, &result.position, &system);
  };
  result.inlier.assign(count, true);
  bool all_agree = solve(result.inlier);
  if (all_agree) {
    const std::vector<bool> agrees = Agreeing(observations, result.position, options.largest_error, &cost);
    all_agree = CountTrue(agrees) == count;
  }
  if (!all_agree) {
    const int fewest = std::max(3, static_cast<int>(std::ceil(options.least_inlier_share * count)));
    result.inlier = BestPair(observations, options.largest_error);
    for (int round = 0; round < 5; ++round) {
      if (CountTrue(result.inlier) < fewest || !solve(result.inlier)) return std::nullopt;
      std::vector<bool> agrees = Agreeing(observations, result.position, options.largest_error, &cost);
      if (agrees == result.inlier || round == 4) break;
      result.inlier = std::move(agrees);
    }
  }
  for (int i = 0; i < count; ++i) {
    if (result.inlier[i] && (result.position - observations[i].centre).norm() > options.farthest)
      return std::nullopt;
  }
  result.inliers = CountTrue(result.inlier);
  result.parallax = LargestParallax(observations, result.inlier, result.position);
  if (result.parallax < options.least_parallax_deg * M_PI / 180.0) return std::nullopt;
  const Eigen::LLT<Eigen::Matrix3d> factor(system.H);
  if (factor.info() != Eigen::Success) return std::nullopt;
  result.covariance = factor.solve(Eigen::Matrix3d::Identity());
  result.rms = std::sqrt(system.cost / std::max(1, 2 * result.inliers - 3));
  return result;
}

}  // namespace mlic
