#include "mlic_core/association/group_errors.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "mlic_core/common/parallel.h"
#include "mlic_core/problem/plane_terms.h"

namespace mlic {
namespace {

// The sum of a group's whitened residuals, weights taken in, and its variance where these are white.
struct GroupSum {
  int lidar;
  double weight;  // PlaneObservation::weight, one for all of the group
  double points;  // the sum of their robust weights
  double total, variance;
};

std::vector<GroupSum> SumsOfPlane(const PlaneAssociation& association, const CalibrationState& state,
                                  std::size_t drive, std::size_t plane) {
  const PlaneRows rows = RowsOfPlane(association, state, drive, plane);
  const auto by_plane = rows.jacobian.bottomRows<3>();
  const auto solver = PlaneInformation(rows);
  const std::vector<Eigen::Index> groups = GroupBegins(association, rows.observations);
  std::vector<GroupSum> sums;
  for (std::size_t g = 0; g + 1 < groups.size(); ++g) {
    const Eigen::Index begin = groups[g], size = groups[g + 1] - begin;
    const auto units = rows.units.segment(begin, size);
    const Eigen::Vector3d followed = by_plane.middleCols(begin, size) * units;
    const PlaneObservation& first = association.observations[rows.observations[begin]];
    const double weights = units.squaredNorm();
    sums.push_back({first.lidar, first.weight, weights / first.weight,
                    units.dot(rows.residuals.segment(begin, size)),
                    weights - followed.dot(solver.solve(followed))});
  }
  return sums;
}

std::vector<GroupSum> SumGroups(const std::vector<DriveTerms>& drives, const CalibrationState& state) {
  std::vector<GroupSum> sums;
  for (std::size_t d = 0; d < drives.size(); ++d) {
    const PlaneAssociation& association = drives[d].planes;
    std::vector<std::vector<GroupSum>> of_planes(association.planes.size());
    ParallelFor(of_planes.size(),
                [&](std::size_t p) { of_planes[p] = SumsOfPlane(association, state, d, p); });
    for (const std::vector<GroupSum>& of_plane : of_planes) {
      sums.insert(sums.end(), of_plane.begin(), of_plane.end());
    }
  }
  return sums;
}

}  // namespace

double GrowthOf(const PlaneNoise& noise, double points) {
  const double at = std::clamp(std::log2(std::max(1.0, points)), 0.0, noise.shared.size() - 1.0);
  const auto below = std::min(static_cast<std::size_t>(at), noise.shared.size() - 2);
  const double share = at - static_cast<double>(below);
  return 1.0 + (1.0 - share) * noise.shared[below] + share * noise.shared[below + 1];
}

void WeighGroups(const std::vector<PlaneNoise>& noise, std::size_t plane, PlaneAssociation* association) {
  std::vector<std::size_t> places(association->begin[plane + 1] - association->begin[plane]);
  std::iota(places.begin(), places.end(), association->begin[plane]);
  const std::vector<Eigen::Index> groups = GroupBegins(*association, places);
  for (std::size_t g = 0; g + 1 < groups.size(); ++g) {
    const double points = static_cast<double>(groups[g + 1] - groups[g]);
    for (Eigen::Index i = groups[g]; i < groups[g + 1]; ++i) {
      PlaneObservation& o = association->observations[places[i]];
      o.weight = static_cast<float>(1.0 / GrowthOf(noise[o.lidar], points));
    }
  }
}

void MeasureSharedErrors(const std::vector<DriveTerms>& drives, const CalibrationState& state,
                         std::vector<PlaneNoise>* noise) {
  constexpr double kFewestGroups = 50.0;  // of an octave; from: guard
  constexpr double kLeastVariance = 0.5;  // of a point's: the plane follows the rest; from: guard
  using Octaves = decltype(PlaneNoise::shared);
  std::vector<Octaves> squares(noise->size(), Octaves{}), counts(squares);
  for (const GroupSum& sum : SumGroups(drives, state)) {
    if (sum.variance < kLeastVariance * sum.weight || sum.points < 1.0) continue;
    const auto octave =
        std::min(counts[0].size() - 1, static_cast<std::size_t>(std::lround(std::log2(sum.points))));
    squares[sum.lidar][octave] += sum.total * sum.total / (sum.weight * sum.variance);
    counts[sum.lidar][octave] += 1.0;
  }
  for (std::size_t l = 0; l < noise->size(); ++l) {
    double shared = 0.0;
    for (std::size_t k = 0; k < counts[l].size(); ++k) {
      if (counts[l][k] >= kFewestGroups) shared = std::max(shared, squares[l][k] / counts[l][k] - 1.0);
      (*noise)[l].shared[k] = shared;
    }
  }
}

double CorrelationFactor(const std::vector<DriveTerms>& drives, const CalibrationState& state) {
  double squares = 0.0, variances = 0.0;
  for (const GroupSum& sum : SumGroups(drives, state)) {
    squares += sum.total * sum.total;
    variances += sum.variance;
  }
  return variances > 0.0 ? std::max(1.0, squares / variances) : 1.0;
}

}  // namespace mlic
