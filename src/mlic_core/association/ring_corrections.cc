#include "mlic_core/association/ring_corrections.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "mlic_core/association/ring_errors.h"
#include "mlic_core/common/parallel.h"
#include "mlic_core/problem/plane_terms.h"

namespace mlic {
namespace {

constexpr std::size_t kFewestRings = 8;     // from: guard
constexpr std::uint16_t kMostRings = 1024;  // higher numbers are no rings; from: guard
constexpr double kFewestPoints = 300.0;     // of a ring, in either half; from: guard
constexpr double kLeastEvidence = 2.0;      // of two variances more; from: derivation, Akaike (1974)
constexpr double kLeastMove = 0.1;          // of what a ring shows, in its sigmas; from: structural
constexpr double kMostDecades = 2.0;        // from: guard, what a LiDAR of 8 bits tells apart
constexpr std::size_t kChunks = 16;         // from: structural

// Towards higher elevation, one unit long times the distance from the z axis' foot: d position / d elevation.
Eigen::Vector3d ElevationTangent(const Eigen::Vector3d& x) {
  const double across = std::hypot(x.x(), x.y());
  if (across < 1e-3) return Eigen::Vector3d::Zero();
  return Eigen::Vector3d(-x.z() * x.x() / across, -x.z() * x.y() / across, across);
}

// What the points of one ring show of errors beyond the corrections that they have.
struct RingSum {
  RingEquations equations;
  double count = 0.0, elevation = 0.0;

  void Add(const RingSum& other) {
    equations.information += other.equations.information;
    equations.gradient += other.equations.gradient;
    count += other.count;
    elevation += other.elevation;
  }
};

using Rings = std::vector<RingSum>;
// One LiDAR's points by the half of the drive and by the side of its view: early left, early right, late
// left, late right.
using Quarters = std::array<Rings, 4>;

// The middle of each LiDAR's view, as far as it takes part.
std::vector<Eigen::Vector3d> ViewCentres(const PlaneAssociation& association, std::size_t lidars) {
  std::vector<Eigen::Vector3d> centres(lidars, Eigen::Vector3d::Zero());
  for (const PlaneObservation& o : association.observations) {
    centres[o.lidar] += o.position.cast<double>().normalized();
  }
  return centres;
}

struct RingSums {
  const PlaneAssociation& association;
  const CalibrationState& state;
  const SplitSpline& trajectory;
  std::vector<float> residuals;
  std::vector<Eigen::Vector3d> centres;

  void AddPlane(std::size_t p, std::vector<Quarters>* sums) const;
};

void RingSums::AddPlane(std::size_t p, std::vector<Quarters>* sums) const {
  for (std::size_t k = association.begin[p]; k < association.begin[p + 1]; ++k) {
    const PlaneObservation& o = association.observations[k];
    const double whitened = residuals[k] / o.sigma;
    const double t = state.lidars[o.lidar].OnImuClock(o.time, trajectory.Middle());
    if (o.ring >= kMostRings || std::abs(whitened) > 3.0 || !trajectory.Contains(t)) continue;
    const Eigen::Vector3d x = o.position.cast<double>();
    const Eigen::Vector2d row = RingJacobian(o, association.planes[p], state.lidars[o.lidar], trajectory);
    const Eigen::Vector3d& centre = centres[o.lidar];
    const bool right = centre.x() * x.y() < centre.y() * x.x();
    const bool late = t > trajectory.Middle();
    Rings& rings = (*sums)[o.lidar][2 * late + right];
    if (rings.size() <= o.ring) rings.resize(o.ring + 1);
    RingSum& sum = rings[o.ring];
    const double weight = o.weight / (static_cast<double>(o.sigma) * o.sigma);
    sum.equations.information += weight * row * row.transpose();
    sum.equations.gradient += weight * residuals[k] * row;
    sum.count += 1.0;
    sum.elevation += ElevationOf(o.position);
  }
}

void AddTo(const Rings& more, Rings* rings) {
  if (rings->size() < more.size()) rings->resize(more.size());
  for (std::size_t r = 0; r < more.size(); ++r) (*rings)[r].Add(more[r]);
}

std::vector<Quarters> SumRings(const std::vector<DriveTerms>& drives, const CalibrationState& state) {
  const std::size_t lidars = state.lidars.size();
  std::vector<Quarters> sums(lidars);
  for (std::size_t d = 0; d < drives.size(); ++d) {
    const PlaneAssociation& association = drives[d].planes;
    const RingSums of_drive{association, state, state.drives[d].trajectory,
                            PlaneResiduals(association, state, d), ViewCentres(association, lidars)};
    std::vector<std::vector<Quarters>> parts(kChunks, std::vector<Quarters>(lidars));
    ParallelChunks(association.planes.size(), kChunks,
                   [&](std::size_t chunk, std::size_t begin, std::size_t end) {
                     for (std::size_t p = begin; p < end; ++p) of_drive.AddPlane(p, &parts[chunk]);
                   });
    for (const auto& part : parts) {
      for (std::size_t l = 0; l < lidars; ++l) {
        for (int quarter = 0; quarter < 4; ++quarter) AddTo(part[l][quarter], &sums[l][quarter]);
      }
    }
  }
  return sums;
}

// The rings that have enough points in every half, from the lowest to the highest.
std::vector<std::size_t> RichRings(const std::array<Rings, 4>& halves) {
  std::vector<std::size_t> which;
  for (std::size_t r = 0; r < halves[0].size(); ++r) {
    const auto is_rich = [&](const Rings& half) { return r < half.size() && half[r].count >= kFewestPoints; };
    if (std::all_of(halves.begin(), halves.end(), is_rich)) which.push_back(r);
  }
  const auto elevation = [&](std::size_t r) { return halves[0][r].elevation / halves[0][r].count; };
  std::sort(which.begin(), which.end(),
            [&](std::size_t a, std::size_t b) { return elevation(a) < elevation(b); });
  return which;
}

Eigen::MatrixX2d CorrectionsOf(const RingCorrections& corrections, const std::vector<std::size_t>& which) {
  Eigen::MatrixX2d values = Eigen::MatrixX2d::Zero(static_cast<Eigen::Index>(which.size()), 2);
  for (std::size_t i = 0; i < which.size(); ++i) {
    if (which[i] >= corrections.size()) continue;
    const RingCorrection& c = corrections[which[i]];
    values.row(static_cast<Eigen::Index>(i)) << c.range, c.elevation;
  }
  return values;
}

// About no correction. correlation: by which the points' information is too large.
std::vector<RingEquations> EquationsOf(const Rings& sums, const std::vector<std::size_t>& which,
                                       const Eigen::MatrixX2d& corrections, double correlation) {
  std::vector<RingEquations> equations;
  for (std::size_t i = 0; i < which.size(); ++i) {
    const RingEquations beyond = which[i] < sums.size() ? sums[which[i]].equations : RingEquations{};
    const Eigen::Vector2d corrected = corrections.row(static_cast<Eigen::Index>(i));
    equations.push_back(
        {beyond.information / correlation, (beyond.gradient - beyond.information * corrected) / correlation});
  }
  return equations;
}

// Of the quarters: early, late, left and right ones. from: structural
constexpr std::size_t kHalves[4][2] = {{0, 1}, {2, 3}, {0, 2}, {1, 3}};

std::vector<RingEquations> Sum(std::vector<RingEquations> a, const std::vector<RingEquations>& b) {
  for (std::size_t i = 0; i < a.size(); ++i) {
    a[i].information += b[i].information;
    a[i].gradient += b[i].gradient;
  }
  return a;
}

// What the points show of a LiDAR's rings, all together and by quarters.
struct RingEvidence {
  std::vector<RingEquations> all;
  std::vector<std::vector<RingEquations>> quarters;
  Eigen::MatrixXd trend;
};

// Of all points, less sure by what quarters differ by beyond the noise of their points.
std::vector<RingEquations> WithScatter(const RingEvidence& rings, bool in_elevation) {
  const Eigen::Vector2d variances = MeasureRingVariances(rings.all, in_elevation).variances;
  const Eigen::MatrixX2d errors = PredictRingErrors(rings.all, rings.trend, variances);
  const double scatter = std::max(1.0, ScatterOfParts(rings.quarters, rings.trend, errors));
  std::vector<RingEquations> all = rings.all;
  for (RingEquations& ring : all) {
    ring.information /= scatter;
    ring.gradient /= scatter;
  }
  return all;
}

// The errors that the rings show and all halves of the points confirm; zero where they do not.
Eigen::MatrixX2d ConfirmedErrors(const RingEvidence& rings) {
  const Eigen::MatrixX2d none = Eigen::MatrixX2d::Zero(rings.trend.rows(), 2);
  std::vector<RingEquations> all = WithScatter(rings, false);
  RingVariances found = MeasureRingVariances(all, false);
  if (MeasureRingVariances(all, true).evidence > found.evidence + kLeastEvidence) {
    all = WithScatter(rings, true);
    found = MeasureRingVariances(all, true);
  }
  if (found.evidence < kLeastEvidence) return none;
  for (const auto& [a, b] : kHalves) {
    const auto half = Sum(rings.quarters[a], rings.quarters[b]);
    const auto other = Sum(rings.quarters[3 - a], rings.quarters[3 - b]);
    const Eigen::MatrixX2d errors = PredictRingErrors(half, rings.trend, found.variances);
    if (GainOfCorrections(other, rings.trend, errors) <= 0.0) return none;
  }
  return PredictRingErrors(all, rings.trend, found.variances);
}

// Root mean square over what the rings show, in its sigmas.
double InSigmas(const std::vector<RingEquations>& rings, const Eigen::MatrixX2d& change) {
  double squares = 0.0;
  for (std::size_t i = 0; i < rings.size(); ++i) {
    const Eigen::Vector2d own = change.row(static_cast<Eigen::Index>(i));
    squares += own.dot(rings[i].information * own);
  }
  return std::sqrt(squares / (2.0 * static_cast<double>(rings.size())));
}

// False where they stay.
bool Improve(const Quarters& quarters, double correlation, RingCorrections* corrections) {
  std::array<Rings, 4> sums;
  for (int h = 0; h < 4; ++h) {
    for (const std::size_t quarter : kHalves[h]) AddTo(quarters[quarter], &sums[h]);
  }
  const std::vector<std::size_t> which = RichRings(sums);
  if (which.size() < kFewestRings) return false;
  Rings both = sums[0];
  AddTo(sums[1], &both);
  const Eigen::MatrixX2d before = CorrectionsOf(*corrections, which);
  Eigen::VectorXd elevations(before.rows());
  for (std::size_t i = 0; i < which.size(); ++i) {
    elevations[static_cast<Eigen::Index>(i)] = both[which[i]].elevation / both[which[i]].count;
  }
  RingEvidence rings{EquationsOf(both, which, before, correlation), {}, RingTrend(elevations)};
  for (const Rings& quarter : quarters) {
    rings.quarters.push_back(EquationsOf(quarter, which, before, correlation));
  }
  const Eigen::MatrixX2d errors = ConfirmedErrors(rings);
  if (InSigmas(rings.all, errors - before) < kLeastMove) return false;
  if (errors.isZero(0.0)) {
    corrections->clear();
    return true;
  }
  const std::size_t highest = *std::max_element(which.begin(), which.end());
  corrections->resize(std::max(corrections->size(), highest + 1));
  for (std::size_t i = 0; i < which.size(); ++i) {
    const auto error = errors.row(static_cast<Eigen::Index>(i));
    (*corrections)[which[i]] = {static_cast<float>(error[0]), static_cast<float>(error[1])};
  }
  return true;
}

}  // namespace

Eigen::Vector2d RingJacobian(const PlaneObservation& o, const MapPlane& plane, const SensorCalibration& lidar,
                             const SplitSpline& trajectory) {
  const So3Spline& rotation = trajectory.rotation;
  const double t = lidar.OnImuClock(o.time, trajectory.Middle());
  const Eigen::Matrix3d R_map_imu = rotation.Evaluate(SplineBasis(rotation.knots(), t)).rotation;
  const Eigen::Vector3d normal =
      lidar.T_imu_sensor.rotation.conjugate() * (R_map_imu.transpose() * plane.plane.normal);
  return {-1.0, normal.dot(ElevationTangent(o.position.cast<double>())) / o.cos_incidence};
}

Eigen::MatrixX2d RingTrend(const Eigen::VectorXd& elevations) {
  Eigen::MatrixX2d trend(elevations.size(), 2);
  trend.col(0).setOnes();
  trend.col(1) = elevations.array() - elevations.mean();
  for (int k = 0; k < 2; ++k) trend.col(k) /= std::max(1e-12, trend.col(k).norm());
  return trend;
}

double ElevationOf(const Eigen::Vector3f& position) {
  const Eigen::Vector3d x = position.cast<double>();
  return std::asin(x.z() / x.norm());
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

bool CorrectRings(const std::vector<DriveTerms>& drives, double correlation,
                  const std::vector<PlaneNoise>& noise, std::vector<UncorrectedMap>* uncorrected,
                  CalibrationState* state) {
  const std::vector<Quarters> sums = SumRings(drives, *state);
  std::vector<std::size_t> points(state->lidars.size(), 0);
  for (const DriveTerms& drive : drives) {
    for (const PlaneObservation& o : drive.planes.observations) ++points[o.lidar];
  }
  state->rings.resize(state->lidars.size());
  uncorrected->resize(state->lidars.size());
  bool changed = false;
  for (std::size_t l = 0; l < sums.size(); ++l) {
    RingCorrections& corrections = state->rings[l];
    UncorrectedMap& without = (*uncorrected)[l];
    if (without.is_better) continue;
    if (corrections.empty()) without = {points[l], noise[l].Sigma(1.0)};
    without.is_better = points[l] < without.points && noise[l].Sigma(1.0) > without.noise;
    if (without.is_better) {
      corrections.clear();
      changed = true;
    } else {
      changed |= Improve(sums[l], correlation, &corrections);
    }
  }
  return changed;
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
