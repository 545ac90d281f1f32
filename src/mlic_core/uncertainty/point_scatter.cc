#include "mlic_core/uncertainty/point_scatter.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "mlic_core/association/ring_corrections.h"
#include "mlic_core/common/parallel.h"
#include "mlic_core/factors/point_to_plane.h"
#include "mlic_core/geometry/symmetric_matrix.h"
#include "mlic_core/problem/plane_terms.h"
#include "mlic_core/uncertainty/intrinsics_observability.h"

namespace mlic {
namespace {

struct Scatter {
  Eigen::MatrixXd found;  // sum of m m^T
  Eigen::MatrixXd white;  // sum of V
  std::vector<Eigen::MatrixXd>
      rings;  // of each LiDAR, what errors of its rings (DoubtOfRings) do to the gradient

  Scatter(Eigen::Index parameters, const std::vector<Eigen::MatrixXd>& doubts);
  void Add(const Scatter& other);
};

Scatter::Scatter(Eigen::Index parameters, const std::vector<Eigen::MatrixXd>& doubts)
    : found(Eigen::MatrixXd::Zero(parameters, parameters)), white(found) {
  for (const Eigen::MatrixXd& doubt : doubts)
    rings.emplace_back(Eigen::MatrixXd::Zero(parameters, doubt.rows()));
}

void Scatter::Add(const Scatter& other) {
  found += other.found;
  white += other.white;
  for (std::size_t l = 0; l < rings.size(); ++l) rings[l] += other.rings[l];
}

// The rows of a plane's points by the calibration, control points left free: a column for each.
Eigen::MatrixXd WithFreeKnots(const LinearizationPoint& at, const Eigen::MatrixXd& knot_response,
                              std::size_t drive, const PlaneRows& rows) {
  const PlaneAssociation& association = at.problem.drives[drive].planes;
  const SplitSpline& trajectory = at.state.drives[drive].trajectory;
  Eigen::MatrixXd reduced = Eigen::MatrixXd::Zero(knot_response.rows(), rows.jacobian.cols());
  for (Eigen::Index i = 0; i < rows.jacobian.cols(); ++i) {
    const PlaneObservation& o = association.observations[rows.observations[i]];
    const double t = at.state.lidars[o.lidar].OnImuClock(o.time, trajectory.Middle());
    const KnotColumns columns(at.layout, drive, SplineBasis(trajectory.rotation.knots(), t).first,
                              SplineBasis(trajectory.position.knots(), t).first);
    auto own = reduced.col(i);
    own.segment<Layout::kOfSensor>(Layout::Lidar(o.lidar)) =
        rows.jacobian.block<Layout::kOfSensor, 1>(PointToPlane::kExtrinsic, i);
    if (const int drift = at.layout.Drift(LidarId(o.lidar)); drift >= 0) {
      own[drift] = (o.time - trajectory.Middle()) * rows.jacobian(PointToPlane::kTimeOffset, i);
    }
    for (int k = 0; k < 8; ++k) {
      own.noalias() -= knot_response.middleCols<3>(columns[k]) * rows.jacobian.block<3, 1>(3 * k, i);
    }
  }
  return reduced;
}

// reduced: the columns of `rows` by the calibration, all else followed.
void AddRings(const LinearizationPoint& at, std::size_t drive, std::size_t plane, const PlaneRows& rows,
              const Eigen::MatrixXd& reduced, Scatter* scatter) {
  const PlaneAssociation& association = at.problem.drives[drive].planes;
  for (Eigen::Index i = 0; i < reduced.cols(); ++i) {
    const PlaneObservation& o = association.observations[rows.observations[i]];
    Eigen::MatrixXd& response = scatter->rings[o.lidar];
    const Eigen::Index count = response.cols() / 2;
    if (o.ring >= count) continue;
    const double whiten = rows.units[i] / o.sigma;
    const Eigen::Vector2d row =
        whiten * RingJacobian(o, rows.residuals[i] / whiten, association.planes[plane],
                              at.state.lidars[o.lidar], at.state.drives[drive].trajectory);
    response.col(o.ring) += row[0] * reduced.col(i);
    response.col(count + o.ring) += row[1] * reduced.col(i);
  }
}

void AddPlane(const LinearizationPoint& at, const Eigen::MatrixXd& knot_response, std::size_t drive,
              std::size_t plane, Scatter* scatter) {
  const PlaneAssociation& association = at.problem.drives[drive].planes;
  const PlaneRows rows = RowsOfPlane(association, at.state, drive, plane);
  if (rows.observations.empty()) return;
  const Eigen::MatrixXd by_plane = rows.jacobian.bottomRows<3>();
  const auto solver = PlaneInformation(rows);
  Eigen::MatrixXd reduced = WithFreeKnots(at, knot_response, drive, rows);
  const Eigen::MatrixXd coupling = reduced * by_plane.transpose();
  reduced.noalias() -= solver.solve(coupling.transpose()).transpose() * by_plane;
  const std::vector<Eigen::Index> groups = GroupBegins(association, rows.observations);
  for (std::size_t g = 0; g + 1 < groups.size(); ++g) {
    const Eigen::Index begin = groups[g], size = groups[g + 1] - begin;
    const auto own = reduced.middleCols(begin, size);
    const Eigen::VectorXd move = own * rows.residuals.segment(begin, size);
    scatter->found.noalias() += move * move.transpose();
    scatter->white.noalias() += own * own.transpose();
    const Eigen::MatrixXd followed = own * by_plane.middleCols(begin, size).transpose();
    scatter->white.noalias() -= followed * solver.solve(followed.transpose());
  }
  AddRings(at, drive, plane, rows, reduced, scatter);
}

// Of `found` along the directions in which it exceeds `usual` times `white`, by the excess. limits: steps of
// the parameters that count as large, so that their units do not matter.
Eigen::MatrixXd Excess(const Scatter& scatter, double usual, const Eigen::VectorXd& limits) {
  const Eigen::MatrixXd in_limits = limits.asDiagonal() * scatter.white * limits.asDiagonal();
  const Eigen::MatrixXd found = limits.asDiagonal() * scatter.found * limits.asDiagonal();
  const SymmetricEigen<Eigen::Dynamic> white(0.5 * (in_limits + in_limits.transpose()));
  const double least = 1e-12 * std::max(1e-300, white.eigenvalues().maxCoeff());
  const Eigen::VectorXd root = white.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  const Eigen::VectorXd inverse =
      root.unaryExpr([&](double v) { return v * v > least ? 1.0 / v : 0.0; });  // nothing is shown there
  const Eigen::MatrixXd whiten = white.eigenvectors() * inverse.asDiagonal();
  const SymmetricEigen<Eigen::Dynamic> ratio(whiten.transpose() * found * whiten);
  const Eigen::VectorXd beyond =
      ratio.eigenvalues().unaryExpr([&](double q) { return std::max(0.0, q / usual - 1.0); });
  const Eigen::MatrixXd back =
      limits.cwiseInverse().asDiagonal() * white.eigenvectors() * root.asDiagonal() * ratio.eigenvectors();
  return back * beyond.asDiagonal() * back.transpose();
}

}  // namespace

Eigen::MatrixXd ScatterOfPoints(const LinearizedProblem& linearized, double usual) {
  const Layout& layout = linearized.layout;
  const CalibrationState& state = linearized.state;
  if (!linearized.solved) return Eigen::MatrixXd::Zero(layout.calibration, layout.calibration);
  const LinearizationPoint at = linearized.At();
  const std::vector<Eigen::MatrixXd> doubts = DoubtOfRings(at.problem.drives, usual, state);
  std::vector<Scatter> parts(kLinearizationChunks, Scatter(layout.calibration, doubts));
  for (std::size_t d = 0; d < at.problem.drives.size(); ++d) {
    ParallelChunks(at.problem.drives[d].planes.planes.size(), parts.size(),
                   [&](std::size_t chunk, std::size_t begin, std::size_t end) {
                     for (std::size_t p = begin; p < end; ++p) {
                       AddPlane(at, linearized.knot_response, d, p, &parts[chunk]);
                     }
                   });
  }
  for (std::size_t c = 1; c < parts.size(); ++c) parts[0].Add(parts[c]);
  Eigen::MatrixXd scatter = Excess(parts[0], usual, CalibrationLimits(state, layout));
  for (std::size_t l = 0; l < doubts.size(); ++l) {
    const Eigen::MatrixXd& response = parts[0].rings[l];
    scatter += response * doubts[l] * response.transpose() / usual;
  }
  return scatter;
}

}  // namespace mlic
