#include "mlic_core/association/ring_corrections.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "mlic_core/association/ring_errors.h"
#include "mlic_core/association/ring_sums.h"

namespace mlic {
namespace {

constexpr std::size_t kFewestRings = 8;  // from: guard
constexpr double kFewestPoints = 30.0;   // of a ring, in either half; from: guard, fewer are no sample
constexpr double kLeastEvidence = 2.0;   // of two variances more; from: derivation, Akaike (1974)
// Of what a ring shows, in its sigmas; from: structural, the doubt has what is left
constexpr double kLeastMove = 0.5;
constexpr double kMostDecades = 2.0;  // from: guard, what a LiDAR of 8 bits tells apart

// Of the quarters: early, late, left and right ones, each beside its other half. from: structural
constexpr std::size_t kHalves[4][2] = {{0, 1}, {2, 3}, {0, 2}, {1, 3}};

// The rings that have so many points in every half, from the lowest to the highest; their mean elevations.
struct SortedRings {
  std::vector<std::size_t> which;
  Eigen::VectorXd elevations;  // rad

  SortedRings(const QuartersOfRings& quarters, double fewest_points) {
    std::vector<double> of_ring;
    for (std::size_t r = 0; r < quarters[0].points.size(); ++r) {
      const auto is_rich = [&](const std::size_t(&half)[2]) {
        return quarters[half[0]].points[r].count + quarters[half[1]].points[r].count >= fewest_points;
      };
      double count = 0.0, elevation = 0.0;
      for (const RingSum& quarter : quarters) {
        count += quarter.points[r].count;
        elevation += quarter.points[r].elevation;
      }
      of_ring.push_back(elevation / std::max(1.0, count));
      if (count > 0.0 && std::all_of(std::begin(kHalves), std::end(kHalves), is_rich)) which.push_back(r);
    }
    std::sort(which.begin(), which.end(),
              [&](std::size_t a, std::size_t b) { return of_ring[a] < of_ring[b]; });
    elevations.resize(static_cast<Eigen::Index>(which.size()));
    for (std::size_t i = 0; i < which.size(); ++i) {
      elevations[static_cast<Eigen::Index>(i)] = of_ring[which[i]];
    }
  }
};

Eigen::MatrixX2d CorrectionsOf(const RingCorrections& corrections, const std::vector<std::size_t>& which) {
  Eigen::MatrixX2d values = Eigen::MatrixX2d::Zero(static_cast<Eigen::Index>(which.size()), 2);
  for (std::size_t i = 0; i < which.size(); ++i) {
    if (which[i] >= corrections.size()) continue;
    const RingCorrection& c = corrections[which[i]];
    values.row(static_cast<Eigen::Index>(i)) << c.range, c.elevation;
  }
  return values;
}

// Where the ranges of some rings stand, then their elevations, among those of `rings`.
std::vector<Eigen::Index> PlacesOf(const std::vector<std::size_t>& which, Eigen::Index rings) {
  std::vector<Eigen::Index> places;
  for (const Eigen::Index start : {Eigen::Index{0}, rings}) {
    for (const std::size_t ring : which) places.push_back(start + static_cast<Eigen::Index>(ring));
  }
  return places;
}

// Of some of a LiDAR's rings, about no correction. correlation: by which the points' information is too
// large.
RingEquations EquationsOf(const RingEquations& beyond, const std::vector<std::size_t>& which,
                          const Eigen::MatrixX2d& corrections, double correlation) {
  const std::vector<Eigen::Index> places = PlacesOf(which, beyond.Rings());
  RingEquations equations{beyond.information(places, places) / correlation,
                          beyond.gradient(places) / correlation};
  const Eigen::Index rings = corrections.rows();
  equations.gradient -= equations.information.leftCols(rings) * corrections.col(0) +
                        equations.information.rightCols(rings) * corrections.col(1);
  return equations;
}

RingEquations Sum(const RingEquations& a, const RingEquations& b) {
  return {a.information + b.information, a.gradient + b.gradient};
}

// What the points show of a LiDAR's rings, all together and by quarters.
struct RingEvidence {
  std::vector<RingEquations> quarters;
  RingEquations all;
  Eigen::MatrixXd trend;
  RingVariances found;

  RingEvidence(const QuartersOfRings& sums, const SortedRings& sorted, const Eigen::MatrixX2d& corrections,
               double correlation);

 private:
  // Less sure by what quarters differ by beyond the noise of their points. given: of all points.
  RingEquations WithScatter(const RingEquations& given, bool in_elevation) const;
};

RingEvidence::RingEvidence(const QuartersOfRings& sums, const SortedRings& sorted,
                           const Eigen::MatrixX2d& corrections, double correlation)
    : all(RingEquations::Zero(corrections.rows())), trend(RingTrend(sorted.elevations)) {
  for (const RingSum& quarter : sums) {
    quarters.push_back(EquationsOf(quarter.equations, sorted.which, corrections, correlation));
    all = Sum(all, quarters.back());
  }
  const RingEquations given = all;
  all = WithScatter(given, false);
  found = MeasureRingVariances(all, false);
  if (MeasureRingVariances(all, true).evidence < found.evidence + kLeastEvidence) return;
  all = WithScatter(given, true);
  found = MeasureRingVariances(all, true);
}

RingEquations RingEvidence::WithScatter(const RingEquations& given, bool in_elevation) const {
  const RingVariances variances = MeasureRingVariances(given, in_elevation);
  const RingPrediction prediction = PredictRingErrors(WithoutTrend(given, trend), variances.variances);
  std::vector<RingEquations> parts;
  for (const RingEquations& quarter : quarters) parts.push_back(WithoutTrend(quarter, trend));
  const double scatter = std::max(1.0, ScatterOfParts(parts, trend.cols(), prediction.errors));
  return {given.information / scatter, given.gradient / scatter};
}

// The errors that the rings show and all halves of the points confirm; zero where they do not.
Eigen::MatrixX2d ConfirmedErrors(const RingEvidence& rings) {
  const Eigen::MatrixX2d none = Eigen::MatrixX2d::Zero(rings.trend.rows(), 2);
  if (rings.found.evidence < kLeastEvidence) return none;
  std::vector<RingEquations> halves;
  for (const auto& [a, b] : kHalves) {
    halves.push_back(WithoutTrend(Sum(rings.quarters[a], rings.quarters[b]), rings.trend));
  }
  for (std::size_t h = 0; h < halves.size(); ++h) {
    const RingPrediction of_half = PredictRingErrors(halves[h], rings.found.variances);
    if (GainOfCorrections(halves[h ^ 1], of_half.errors) <= 0.0) return none;
  }
  return PredictRingErrors(WithoutTrend(rings.all, rings.trend), rings.found.variances).errors;
}

// Root mean square over what the rings show, in its sigmas.
double InSigmas(const RingEquations& rings, const Eigen::MatrixX2d& change) {
  const Eigen::Index count = rings.Rings();
  const Eigen::VectorXd moved =
      rings.information.leftCols(count) * change.col(0) + rings.information.rightCols(count) * change.col(1);
  const double squares = change.col(0).dot(moved.head(count)) + change.col(1).dot(moved.tail(count));
  return std::sqrt(squares / static_cast<double>(2 * count));
}

// False where they stay.
bool Improve(const QuartersOfRings& sums, double correlation, RingCorrections* corrections) {
  const SortedRings sorted(sums, kFewestPoints);
  if (sorted.which.size() < kFewestRings) return false;
  const Eigen::MatrixX2d before = CorrectionsOf(*corrections, sorted.which);
  const RingEvidence rings(sums, sorted, before, correlation);
  const Eigen::MatrixX2d errors = ConfirmedErrors(rings);
  if (InSigmas(rings.all, errors - before) < kLeastMove) return false;
  if (errors.isZero(0.0)) {
    corrections->clear();
    return true;
  }
  const std::size_t highest = *std::max_element(sorted.which.begin(), sorted.which.end());
  corrections->resize(std::max(corrections->size(), highest + 1));
  for (std::size_t i = 0; i < sorted.which.size(); ++i) {
    const auto error = errors.row(static_cast<Eigen::Index>(i));
    (*corrections)[sorted.which[i]] = {static_cast<float>(error[0]), static_cast<float>(error[1])};
  }
  return true;
}

// Of one LiDAR, by the rings' numbers. ranges: what of the trend of its ranges is found elsewhere
// (range_errors.h).
Eigen::MatrixXd DoubtOf(const QuartersOfRings& sums, double correlation, const RingCorrections& corrections,
                        const RangeCorrection& ranges) {
  const auto rings = static_cast<Eigen::Index>(sums[0].points.size());
  Eigen::MatrixXd doubt = Eigen::MatrixXd::Zero(2 * rings, 2 * rings);
  const SortedRings sorted(sums, 0.0);
  if (sorted.which.size() < kFewestRings) return doubt;
  const Eigen::MatrixX2d corrected = CorrectionsOf(corrections, sorted.which);
  const RingEvidence evidence(sums, sorted, corrected, correlation);
  const double elevation_variance = corrected.col(1).isZero(0.0) ? 0.0 : evidence.found.variances[1];
  Eigen::MatrixXd of_sorted = MeanSquareBeyond(evidence.all, evidence.trend, elevation_variance, corrected);
  const bool found[2] = {ranges.offset != 0.0, ranges.slope != 0.0};
  for (int k = 0; k < 2; ++k) {
    if (!found[k]) continue;
    Eigen::VectorXd along = Eigen::VectorXd::Zero(of_sorted.rows());
    along.head(corrected.rows()) = evidence.trend.col(k);
    const Eigen::MatrixXd others =
        Eigen::MatrixXd::Identity(along.size(), along.size()) - along * along.transpose();
    of_sorted = others * of_sorted * others;
  }
  const std::vector<Eigen::Index> places = PlacesOf(sorted.which, rings);
  doubt(places, places) = of_sorted;
  return doubt;
}

}  // namespace

Eigen::MatrixX2d RingTrend(const Eigen::VectorXd& elevations) {
  Eigen::MatrixX2d trend(elevations.size(), 2);
  trend.col(0).setOnes();
  trend.col(1) = elevations.array() - elevations.mean();
  for (int k = 0; k < 2; ++k) trend.col(k) /= std::max(1e-12, trend.col(k).norm());
  return trend;
}

double DecadesOfStrength(float intensity, double reference) {
  if (reference <= 0.0) return 0.0;
  return std::clamp(std::log10(std::max(1e-30, intensity / reference)), -kMostDecades, kMostDecades);
}

Eigen::Vector3f CorrectedPoint(const Eigen::Vector3f& position, const RingCorrection& correction) {
  if (correction.range == 0.0f && correction.elevation == 0.0f) return position;
  const Eigen::Vector3d x = position.cast<double>();
  return (x * (1.0 + correction.range / x.norm()) + correction.elevation * ElevationTangent(x)).cast<float>();
}

Eigen::Vector3f CorrectedPoint(const LidarPoint& point, const CalibrationState& state, std::size_t lidar) {
  RingCorrection correction;
  if (lidar < state.rings.size() && point.ring < state.rings[lidar].size()) {
    correction = state.rings[lidar][point.ring];
  }
  if (lidar < state.ranges.size()) {
    const RangeCorrection& all = state.ranges[lidar];
    correction.range += static_cast<float>(all.offset + all.slope * ElevationOf(point.position) +
                                           all.walk * DecadesOfStrength(point.intensity, all.reference));
  }
  return CorrectedPoint(point.position, correction);
}

PointCorrection CorrectionOfRings(const CalibrationState& state) {
  const bool rings = std::any_of(state.rings.begin(), state.rings.end(),
                                 [](const RingCorrections& of_lidar) { return !of_lidar.empty(); });
  const bool ranges = std::any_of(state.ranges.begin(), state.ranges.end(), [](const RangeCorrection& all) {
    return all.offset != 0.0 || all.slope != 0.0 || all.walk != 0.0;
  });
  if (!rings && !ranges) return nullptr;
  return [&state](std::size_t lidar, const LidarPoint& point) { return CorrectedPoint(point, state, lidar); };
}

bool CorrectRings(const std::vector<DriveTerms>& drives, double correlation, CalibrationState* state) {
  const std::vector<QuartersOfRings> sums = SumRings(drives, *state);
  state->rings.resize(state->lidars.size());
  bool changed = false;
  for (std::size_t l = 0; l < sums.size(); ++l) changed |= Improve(sums[l], correlation, &state->rings[l]);
  return changed;
}

std::vector<Eigen::MatrixXd> DoubtOfRings(const std::vector<DriveTerms>& drives, double correlation,
                                          const CalibrationState& state) {
  std::vector<Eigen::MatrixXd> doubts;
  const std::vector<QuartersOfRings> sums = SumRings(drives, state);
  for (std::size_t l = 0; l < sums.size(); ++l) {
    doubts.push_back(DoubtOf(sums[l], correlation,
                             l < state.rings.size() ? state.rings[l] : RingCorrections{},
                             l < state.ranges.size() ? state.ranges[l] : RangeCorrection{}));
  }
  return doubts;
}

RingCorrection TypicalCorrection(const RingCorrections& corrections) {
  double range = 0.0, elevation = 0.0, count = 0.0;
  for (const RingCorrection& c : corrections) {
    if (c.range == 0.0f && c.elevation == 0.0f) continue;
    range += c.range * c.range;
    elevation += c.elevation * c.elevation;
    count += 1.0;
  }
  if (count == 0.0) return {};
  return {static_cast<float>(std::sqrt(range / count)), static_cast<float>(std::sqrt(elevation / count))};
}

std::string DescribeCorrections(const CalibrationState& state, std::size_t lidar) {
  const RingCorrections& rings = state.rings[lidar];
  const RangeCorrection all = lidar < state.ranges.size() ? state.ranges[lidar] : RangeCorrection{};
  std::string text;
  char part[120];
  if (!rings.empty()) {
    const RingCorrection typical = TypicalCorrection(rings);
    std::snprintf(part, sizeof(part), "; its rings err by %.1f mm in range and %.3f deg in elevation (rms)",
                  1e3 * typical.range, typical.elevation * 180.0 / M_PI);
    text += part;
  }
  if (all.offset != 0.0) {
    std::snprintf(part, sizeof(part), "; its ranges are %.1f mm too %s", 1e3 * std::abs(all.offset),
                  all.offset > 0.0 ? "short" : "long");
    text += part;
  }
  if (all.walk != 0.0) {
    std::snprintf(part, sizeof(part), "; of echoes ten times weaker %.1f mm too %s", 1e3 * std::abs(all.walk),
                  all.walk > 0.0 ? "long" : "short");
    text += part;
  }
  return text.empty() ? text : ":" + text.substr(1) + "; corrected";
}

}  // namespace mlic
