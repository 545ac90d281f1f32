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

// What the errors of a LiDAR's rings do to the gradient.
struct RingResponse {
  Eigen::MatrixXd range, elevation;  // a column for each ring
  Eigen::VectorXd elevations;        // sums over the points: rad
  Eigen::VectorXd points;
};

struct Scatter {
  Eigen::MatrixXd found;            // sum of m m^T
  Eigen::MatrixXd white;            // sum of V
  std::vector<RingResponse> rings;  // of each LiDAR; without columns where nothing was corrected

  Scatter(Eigen::Index parameters, const CalibrationState& state);
  void Add(const Scatter& other);
};

Scatter::Scatter(Eigen::Index parameters, const CalibrationState& state)
    : found(Eigen::MatrixXd::Zero(parameters, parameters)), white(found) {
  for (std::size_t l = 0; l < state.lidars.size(); ++l) {
    const auto count = static_cast<Eigen::Index>(l < state.rings.size() ? state.rings[l].size() : 0);
    const Eigen::MatrixXd none = Eigen::MatrixXd::Zero(parameters, count);
    rings.push_back({none, none, Eigen::VectorXd::Zero(count), Eigen::VectorXd::Zero(count)});
  }
}

void Scatter::Add(const Scatter& other) {
  found += other.found;
  white += other.white;
  for (std::size_t l = 0; l < rings.size(); ++l) {
    rings[l].range += other.rings[l].range;
    rings[l].elevation += other.rings[l].elevation;
    rings[l].elevations += other.rings[l].elevations;
    rings[l].points += other.rings[l].points;
  }
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
    RingResponse& response = scatter->rings[o.lidar];
    if (o.ring >= response.points.size()) continue;
    const Eigen::Vector2d row = rows.units[i] / o.sigma *
                                RingJacobian(o, association.planes[plane], at.state.lidars[o.lidar],
                                             at.state.drives[drive].trajectory);
    response.range.col(o.ring) += row[0] * reduced.col(i);
    response.elevation.col(o.ring) += row[1] * reduced.col(i);
    response.elevations[o.ring] += ElevationOf(o.position);
    response.points[o.ring] += 1.0;
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

// Of the errors that corrections leave in: the trend as far as rings that err like these have one, and all
// that rings without a correction may err by. ranges_found: the trend of the ranges is estimated
// (range_errors.h).
Eigen::MatrixXd LeftOfRings(const RingResponse& response, const RingCorrections& corrections,
                            bool ranges_found) {
  const RingCorrection typical = TypicalCorrection(corrections);
  Eigen::MatrixXd left = Eigen::MatrixXd::Zero(response.range.rows(), response.range.rows());
  const auto add = [&](double sigma, const Eigen::MatrixXd& columns) {
    left.noalias() += sigma * sigma * columns * columns.transpose();
  };
  std::vector<Eigen::Index> corrected;
  for (Eigen::Index r = 0; r < response.points.size(); ++r) {
    if (response.points[r] == 0.0) continue;
    if (corrections[r].range != 0.0f || corrections[r].elevation != 0.0f) {
      corrected.push_back(r);
    } else {
      add(typical.range, response.range.col(r));
      add(typical.elevation, response.elevation.col(r));
    }
  }
  const auto count = static_cast<Eigen::Index>(corrected.size());
  Eigen::VectorXd elevations(count);
  Eigen::MatrixXd range(left.rows(), count), elevation(left.rows(), count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Index r = corrected[i];
    elevations[i] = response.elevations[r] / response.points[r];
    range.col(i) = response.range.col(r);
    elevation.col(i) = response.elevation.col(r);
  }
  if (!ranges_found) add(typical.range, range * RingTrend(elevations));
  add(typical.elevation, elevation * RingTrend(elevations));
  return left;
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
  std::vector<Scatter> parts(kLinearizationChunks, Scatter(layout.calibration, state));
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
  for (std::size_t l = 0; l < state.rings.size(); ++l) {
    if (state.rings[l].empty()) continue;
    const bool ranges_found = l < state.ranges.size() && state.ranges[l].offset != 0.0;
    scatter += LeftOfRings(parts[0].rings[l], state.rings[l], ranges_found) / usual;
  }
  return scatter;
}

}  // namespace mlic
