#include "mlic_core/uncertainty/range_columns.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "mlic_core/association/ring_corrections.h"
#include "mlic_core/association/ring_sums.h"
#include "mlic_core/common/order_statistics.h"

namespace mlic {
namespace {

// Of a beam's incidence: grazing points are few and planes hardly take them. from: structural, keeps
// logarithms finite
constexpr double kLeastCosine = 0.1;
constexpr std::size_t kFewestPoints = 5;  // of one LiDAR on a plane that show its brightness; from: guard

bool Within45Degrees(double cosine) { return cosine * cosine > 0.5; }

// Of each LiDAR, the median of the decades of strength on a plane, about its usual intensity; nothing where
// it sees too little of it.
std::vector<std::optional<double>> BrightnessOfPlane(const PlaneAssociation& planes, std::size_t plane,
                                                     const std::vector<double>& usual) {
  std::vector<std::vector<double>> strengths(usual.size());
  for (std::size_t k = planes.begin[plane]; k < planes.begin[plane + 1]; ++k) {
    const PlaneObservation& o = planes.observations[k];
    if (o.intensity > 0.0f) strengths[o.lidar].push_back(DecadesOfStrength(o.intensity, usual[o.lidar]));
  }
  std::vector<std::optional<double>> brightness(usual.size());
  for (std::size_t l = 0; l < usual.size(); ++l) {
    if (strengths[l].size() >= kFewestPoints) brightness[l] = Median(std::move(strengths[l]));
  }
  return brightness;
}

// Decades by which each LiDAR's strength of a plane exceeds that of the LiDARs before it: the median over the
// planes that both see. Usual intensities are those of what a LiDAR happens to see, bright ground or dark
// facades. 0 for one that shares no plane with those before it.
std::vector<double> RelativeStrengths(const JointProblem& problem, const std::vector<double>& usual) {
  std::vector<double> relative(usual.size(), 0.0);
  if (usual.size() < 2) return relative;
  std::vector<std::vector<std::optional<double>>> of_planes;
  for (const DriveTerms& drive : problem.drives) {
    for (std::size_t p = 0; p < drive.planes.planes.size(); ++p) {
      of_planes.push_back(BrightnessOfPlane(drive.planes, p, usual));
    }
  }
  for (std::size_t l = 1; l < usual.size(); ++l) {
    std::vector<double> differences;
    for (const std::vector<std::optional<double>>& of_plane : of_planes) {
      for (std::size_t before = 0; of_plane[l] && before < l; ++before) {
        if (!of_plane[before]) continue;
        differences.push_back(*of_plane[l] - *of_plane[before] + relative[before]);
      }
    }
    if (!differences.empty()) relative[l] = Median(std::move(differences));
  }
  return relative;
}

// m, half of each LiDAR's points are nearer.
std::vector<double> UsualRanges(const JointProblem& problem, std::size_t lidars) {
  std::vector<std::vector<float>> ranges(lidars);
  for (const DriveTerms& drive : problem.drives) {
    for (const PlaneObservation& o : drive.planes.observations) ranges[o.lidar].push_back(o.position.norm());
  }
  std::vector<double> usual(lidars, 0.0);
  for (std::size_t l = 0; l < lidars; ++l) {
    if (!ranges[l].empty()) usual[l] = Median(std::move(ranges[l]));
  }
  return usual;
}

}  // namespace

std::vector<double> UsualIntensities(const JointProblem& problem, const CalibrationState& state) {
  std::vector<std::vector<float>> intensities(state.lidars.size());
  for (const DriveTerms& drive : problem.drives) {
    for (const PlaneObservation& o : drive.planes.observations) intensities[o.lidar].push_back(o.intensity);
  }
  std::vector<double> usual(intensities.size(), 0.0);
  for (std::size_t l = 0; l < usual.size(); ++l) {
    if (l < state.ranges.size() && state.ranges[l].reference > 0.0) {
      usual[l] = state.ranges[l].reference;
    } else if (!intensities[l].empty()) {
      usual[l] = Median(std::move(intensities[l]));
    }
  }
  return usual;
}

RangeRow::RangeRow(const JointProblem& problem, const std::vector<double>& references)
    : references_(references),
      relative_strengths_(RelativeStrengths(problem, references)),
      usual_ranges_(UsualRanges(problem, references.size())) {}

RangeRow::Vector RangeRow::Of(const PlaneObservation& o, const Plane& plane) const {
  const bool level = Within45Degrees(plane.normal.z()), steep = Within45Degrees(o.cos_incidence);
  const double cosine = std::max(kLeastCosine, static_cast<double>(o.cos_incidence));
  const double strength = DecadesOfStrength(o.intensity, references_[o.lidar]);
  // Along the normal, by brightness and by incidence.
  const double hidden = std::log10(cosine) / cosine;
  const double brightness =
      o.intensity > 0.0f ? (strength - relative_strengths_[o.lidar]) / cosine - hidden : 0.0;
  Vector row = Vector::Zero();
  row[kOne] = 1.0;
  row[kElevation] = ElevationOf(o.position);
  row[kStrength] = strength;
  row[level ? kOnLevel : steep ? kSteep : kOblique] = 1.0;
  if (strength > 0.0) row[kStrengthOfStrong] = strength;
  if (o.position.norm() < usual_ranges_[o.lidar]) row[kStrengthOfNear] = strength;
  if (level) row[kStrengthOfLevel] = strength;
  row[kRangeColumns + (level ? 1 : 0)] = brightness;
  row[kRangeColumns + (level ? 3 : 2)] = hidden;
  return row;
}

Eigen::Matrix<double, kRangeColumns, kRangeParameters> ColumnsOf(RangeModel model) {
  Eigen::Matrix<double, kRangeColumns, kRangeParameters> columns;
  columns.setZero();
  columns(kOnLevel, kRangeLevel) = 1.0;
  if (model == RangeModel::kWhole || model == RangeModel::kByIncidence) {
    columns(kStrength, kRangeWalk) = 1.0;
  }
  if (model == RangeModel::kWhole) {
    columns(kOne, kRangeOffset) = columns(kOneOfSeen, kRangeOffset) = 1.0;
    columns(kElevation, kRangeSlope) = columns(kElevationOfSeen, kRangeSlope) = 1.0;
  } else if (model == RangeModel::kByIncidence) {
    columns(kSteep, kRangeOffset) = columns(kOblique, kRangeSlope) = 1.0;
  } else {
    const RangeColumn part = model == RangeModel::kByStrength ? kStrengthOfStrong
                             : model == RangeModel::kByRange  ? kStrengthOfNear
                                                              : kStrengthOfLevel;
    columns(kOne, kRangeOffset) = columns(part, kRangeWalk) = columns(kStrength, kRangeSlope) = 1.0;
    columns(part, kRangeSlope) = -1.0;
  }
  return columns;
}

}  // namespace mlic
