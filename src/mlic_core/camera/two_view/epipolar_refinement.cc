#include "mlic_core/camera/two_view/epipolar_refinement.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "mlic_core/geometry/so3.h"
#include "mlic_core/geometry/symmetric_matrix.h"

namespace mlic {
namespace {

// Gauss-Newton with damping on Sampson's error e / sqrt(D), with q = R a: e = t . (q x b),
// D = |t x q|^2 + |t x b|^2 - 2 e^2. Unknowns: left perturbation of R (3), t within its tangent plane (2).
struct EpipolarSystem {
  Eigen::Matrix<double, 5, 5> H = Eigen::Matrix<double, 5, 5>::Zero();
  Eigen::Matrix<double, 5, 1> g = Eigen::Matrix<double, 5, 1>::Zero();
  double cost = 0.0;

  void Add(const RelativePose& pose, const Eigen::Matrix<double, 3, 2>& tangents, const Eigen::Vector3d& a,
           const Eigen::Vector3d& b) {
    const Eigen::Vector3d q = pose.R * a;
    const Eigen::Vector3d q_b = q.cross(b), q_t = q.cross(pose.t);
    const double e = pose.t.dot(q_b), tq = pose.t.dot(q), tb = pose.t.dot(b);
    const double D = std::max(1e-12, 2.0 - tq * tq - tb * tb - 2.0 * e * e);
    const Eigen::Vector3d e_R = q.cross(b.cross(pose.t));
    const Eigen::Vector3d D_R = -2.0 * tq * q_t - 4.0 * e * e_R;
    const Eigen::Vector3d D_t = -2.0 * (tq * q + tb * b) - 4.0 * e * q_b;
    const double root = 1.0 / std::sqrt(D), slope = -0.5 * e / D;
    Eigen::Matrix<double, 5, 1> row;
    row.head<3>() = root * (e_R + slope * D_R);
    row.tail<2>() = tangents.transpose() * (root * (q_b + slope * D_t));
    const double r = e * root;
    H.noalias() += row * row.transpose();
    g.noalias() += r * row;
    cost += r * r;
  }
};

}  // namespace

RelativePose RefineRelativePose(RelativePose pose, const std::vector<Eigen::Vector3d>& bearings_a,
                                const std::vector<Eigen::Vector3d>& bearings_b,
                                const std::vector<bool>& used) {
  const auto build = [&](const RelativePose& at, const Eigen::Matrix<double, 3, 2>& tangents) {
    EpipolarSystem system;
    for (std::size_t i = 0; i < used.size(); ++i) {
      if (used[i]) system.Add(at, tangents, bearings_a[i], bearings_b[i]);
    }
    return system;
  };
  const auto tangents_at = [](const Eigen::Vector3d& t) {
    Eigen::Matrix<double, 3, 2> tangents;
    tangents.col(0) = t.unitOrthogonal();
    tangents.col(1) = t.cross(tangents.col(0));
    return tangents;
  };
  Eigen::Matrix<double, 3, 2> tangents = tangents_at(pose.t);
  EpipolarSystem system = build(pose, tangents);
  double damping = 1e-6;
  for (int iteration = 0; iteration < 20 && damping < 1e3; ++iteration) {
    Eigen::Matrix<double, 5, 5> H = system.H;
    H.diagonal() *= 1.0 + damping;
    H.diagonal().array() += 1e-12;
    const Eigen::Matrix<double, 5, 1> step = -SolveSymmetric(H, system.g);
    const RelativePose trial{ExpMatrix(step.head<3>()) * pose.R,
                             (pose.t + tangents * step.tail<2>()).normalized()};
    const Eigen::Matrix<double, 3, 2> trial_tangents = tangents_at(trial.t);
    const EpipolarSystem trial_system = build(trial, trial_tangents);
    if (!(trial_system.cost < system.cost)) {
      damping *= 10.0;
      continue;
    }
    const bool done = system.cost - trial_system.cost < 1e-9 * system.cost;
    pose = trial;
    tangents = trial_tangents;
    system = trial_system;
    damping = std::max(1e-9, 0.1 * damping);
    if (done) break;
  }
  return pose;
}

}  // namespace mlic
