#include "mlic_core/uncertainty/range_errors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "mlic_core/association/ring_corrections.h"
#include "mlic_core/common/order_statistics.h"
#include "mlic_core/geometry/symmetric_matrix.h"
#include "mlic_core/problem/joint_solver.h"
#include "mlic_core/problem/landmark_rows.h"
#include "mlic_core/problem/layout.h"
#include "mlic_core/problem/linearizer.h"
#include "mlic_core/problem/plane_terms.h"
#include "mlic_core/problem/priors.h"
#include "mlic_core/problem/time_windows.h"
#include "mlic_core/solver/normal_equations.h"
#include "mlic_core/uncertainty/widened_equations.h"

namespace mlic {
namespace {

// Of the priors on all parameters: keep what nothing shows where it is. from: guard, LiDARs err by up to
// 0.03 m
constexpr double kPriorSigma = 0.1;
// Of what planes hide at grazing incidence: for each power of ten of its cosine. from: guard, bumps of ground
// and walls are a centimetre high
constexpr double kHiddenSigma = 0.01;
// Of a beam's incidence: grazing points are few and planes hardly take them. from: structural, keeps
// logarithms finite
constexpr double kLeastCosine = 0.1;
// How far planes' relief goes with their brightness, m for each power of ten: of those that are not level,
// and of level ones. from: structural
constexpr int kReliefs = 4;
constexpr std::size_t kFewestPoints = 5;  // of one LiDAR on a plane that show its brightness; from: guard

bool Within45Degrees(double cosine) { return cosine * cosine > 0.5; }

// The parameters beside the calibration's: those of each LiDAR, then the reliefs.
Eigen::Index ExtraParameters(std::size_t lidars) {
  return static_cast<Eigen::Index>(kRangeParameters * lidars) + kReliefs;
}

// The intensity of which half of a LiDAR's echoes are stronger, or what its correction is about.
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

// By what a point's range grows with its LiDAR's parameters and the reliefs.
class RangeRow {
 public:
  static constexpr int kSize = kRangeParameters + kReliefs;  // from: structural
  using Vector = Eigen::Matrix<double, kSize, 1>;

  RangeRow(const LinearizationPoint& at, RangeModel model)
      : model_(model),
        references_(UsualIntensities(at.problem, at.state)),
        relative_strengths_(RelativeStrengths(at.problem, references_)) {
    if (model == RangeModel::kByRange) usual_ranges_ = UsualRanges(at.problem, at.state.lidars.size());
  }

  const std::vector<double>& References() const { return references_; }

  Vector Of(const PlaneObservation& o, const Plane& plane) const {
    const bool level = Within45Degrees(plane.normal.z());
    const double cosine = std::max(kLeastCosine, static_cast<double>(o.cos_incidence));
    const double strength = DecadesOfStrength(o.intensity, references_[o.lidar]);
    // Along the normal, by brightness and by incidence.
    const double hidden = std::log10(cosine) / cosine;
    const double brightness =
        o.intensity > 0.0f ? (strength - relative_strengths_[o.lidar]) / cosine - hidden : 0.0;
    Vector row;
    row << 1.0, ElevationOf(o.position), strength, level ? 1.0 : 0.0, level ? 0.0 : brightness,
        level ? brightness : 0.0, level ? 0.0 : hidden, level ? hidden : 0.0;
    if (model_ == RangeModel::kByIncidence) {
      const bool steep = Within45Degrees(o.cos_incidence);
      row[kRangeOffset] = !level && steep ? 1.0 : 0.0;
      row[kRangeSlope] = !level && !steep ? 1.0 : 0.0;
    } else if (model_ != RangeModel::kWhole) {
      const bool part = model_ == RangeModel::kByStrength ? strength > 0.0
                        : model_ == RangeModel::kByRange  ? o.position.norm() < usual_ranges_[o.lidar]
                                                          : level;
      row[kRangeWalk] = part ? strength : 0.0;
      row[kRangeSlope] = part ? 0.0 : strength;
    }
    return row;
  }

 private:
  RangeModel model_;
  std::vector<double> references_, relative_strengths_, usual_ranges_;
};

// A measurement along a beam as the equations have it: its residual by eight control points, its LiDAR's pose
// and offset (laid out as PointToPlane), its clock's drift, and the plane or point that it measures.
template <typename ByMotion>
struct BeamRow {
  std::size_t lidar;
  const KnotColumns& columns;
  const ByMotion& by;
  double by_drift;
  Eigen::Vector3d by_measured;
  double residual;
};

// What a parameter by which the residual grows so much shares with all others that are no errors of ranges.
template <typename Row>
void AddShared(const LinearizationPoint& at, const Row& row, Eigen::Index to, double own,
               LandmarkCoupling* coupling, Accumulator* sum) {
  const auto share = [&](Eigen::Index with, double value) {
    sum->corner(to, with) += value;
    sum->corner(with, to) += value;
  };
  sum->gradient_calibration[to] += own * row.residual;
  const Eigen::Index sensor = Layout::Lidar(row.lidar);
  for (int k = 0; k < Layout::kOfSensor; ++k) share(sensor + k, own * row.by[PointToPlane::kExtrinsic + k]);
  if (const int drift = at.layout.Drift(LidarId(row.lidar)); drift >= 0) share(drift, own * row.by_drift);
  for (int k = 0; k < 8; ++k) {
    sum->border.template block<1, 3>(to, sum->Local(row.columns[k])) +=
        own * row.by.template segment<3>(3 * k).transpose();
  }
  coupling->calibration.row(to) += own * row.by_measured.transpose();
}

// A longer range makes a residual smaller: it is along the beam.
void AddRangesOfPlane(const LinearizationPoint& at, const RangeRow& range_row, std::size_t drive,
                      std::size_t plane, LandmarkCoupling* coupling, Accumulator* sum) {
  const PlaneAssociation& association = at.problem.drives[drive].planes;
  const SplitSpline& trajectory = at.state.drives[drive].trajectory;
  const PlaneRows rows = RowsOfPlane(association, at.state, drive, plane);
  const Eigen::Index reliefs = at.layout.calibration + ExtraParameters(at.state.lidars.size()) - kReliefs;
  for (Eigen::Index i = 0; i < rows.residuals.size(); ++i) {
    const PlaneObservation& o = association.observations[rows.observations[i]];
    const double t = at.state.lidars[o.lidar].OnImuClock(o.time, trajectory.Middle());
    const RangeRow::Vector own = -rows.units[i] / o.sigma * range_row.Of(o, association.planes[plane].plane);
    const auto by = rows.jacobian.col(i);
    const KnotColumns columns(at.layout, drive, SplineBasis(trajectory.rotation.knots(), t).first,
                              SplineBasis(trajectory.position.knots(), t).first);
    std::array<Eigen::Index, RangeRow::kSize> to;
    for (int k = 0; k < RangeRow::kSize; ++k) {
      to[k] = k < kRangeParameters ? at.layout.calibration + RangeErrors::Of(o.lidar, RangeParameter(k))
                                   : reliefs + k - kRangeParameters;
    }
    const double by_drift = (o.time - trajectory.Middle()) * by[PointToPlane::kTimeOffset];
    const BeamRow<decltype(by)> row{static_cast<std::size_t>(o.lidar),   columns,          by, by_drift,
                                    by.segment<3>(PointToPlane::kPlane), rows.residuals[i]};
    for (int a = 0; a < RangeRow::kSize; ++a) {
      if (own[a] == 0.0) continue;
      for (int b = 0; b < RangeRow::kSize; ++b) sum->corner(to[a], to[b]) += own[a] * own[b];
      AddShared(at, row, to[a], own[a], coupling, sum);
    }
  }
}

// Of a point of the map that a camera sees: what its LiDAR measured along the beam. How strong its echo was
// is not known, so that it takes part in what depends on neither strength nor plane.
void AddRangesOfLandmark(const LinearizationPoint& at, std::size_t drive, std::size_t point,
                         LandmarkCoupling* coupling, Accumulator* sum) {
  namespace rows_of = landmark_rows;
  const LandmarkSet& set = at.problem.drives[drive].landmarks;
  const LidarPointObservation& o = set.lidar_points[point];
  const rows_of::PointChart chart(set.points[point]);
  double cost = 0.0;  // the observations' own, counted already
  rows_of::WithLidarRows(
      at, drive, point, chart.Jacobian().transpose(), &cost,
      [&](const rows_of::Bases& bases, const rows_of::LidarRows& rows) {
        const auto by = rows.col(2);  // along the beam
        const std::array<std::pair<RangeParameter, double>, 2> own = {
            std::pair(kRangeOffset, -1.0 / o.sigma_along),
            std::pair(kRangeSlope, -ElevationOf(o.position.cast<float>()) / o.sigma_along)};
        const KnotColumns columns(at.layout, drive, bases.rotation.first, bases.position.first);
        const BeamRow<decltype(by)> row{static_cast<std::size_t>(o.lidar),
                                        columns,
                                        by,
                                        by[rows_of::kDrift],
                                        by.segment<3>(rows_of::kPoint),
                                        by[rows_of::kResidual]};
        for (const auto& [parameter, size] : own) {
          const Eigen::Index to = at.layout.calibration + RangeErrors::Of(o.lidar, parameter);
          for (const auto& [other, other_size] : own) {
            sum->corner(to, at.layout.calibration + RangeErrors::Of(o.lidar, other)) += size * other_size;
          }
          AddShared(at, row, to, size, coupling, sum);
        }
      });
}

void AddRanges(const LinearizationPoint& at, const RangeRow& row, RangeModel model,
               std::vector<LandmarkCoupling>* couplings, Accumulator* sum) {
  Widen(ExtraParameters(at.state.lidars.size()), sum, couplings);
  LandmarkCoupling* of_drive = couplings->data();
  for (std::size_t d = 0; d < at.problem.drives.size(); ++d) {
    const DriveTerms& drive = at.problem.drives[d];
    for (std::size_t p = 0; p < drive.planes.planes.size(); ++p)
      AddRangesOfPlane(at, row, d, p, of_drive + p, sum);
    for (std::size_t p = 0; model == RangeModel::kWhole && p < drive.landmarks.points.size(); ++p) {
      if (!drive.landmarks.IsOnMap(p)) continue;
      AddRangesOfLandmark(at, d, p, of_drive + drive.planes.planes.size() + p, sum);
    }
    of_drive += drive.planes.planes.size() + drive.landmarks.points.size();
  }
}

struct Prior {
  Eigen::MatrixXd information;
  Eigen::VectorXd gradient;
};

// Of each LiDAR's slope, m/rad: what the errors of its rings, each for itself, leave of one over their
// elevations, these spread as its points are. Corrections of rings leave it out.
std::vector<double> SlopeSigmas(const LinearizationPoint& at) {
  std::vector<Eigen::Array3d> moments(at.state.lidars.size(), Eigen::Array3d::Zero());  // of elevations
  for (const DriveTerms& drive : at.problem.drives) {
    for (const PlaneObservation& o : drive.planes.observations) {
      const double elevation = ElevationOf(o.position);
      moments[o.lidar] += Eigen::Array3d(1.0, elevation, elevation * elevation);
    }
  }
  std::vector<double> sigmas(moments.size(), kPriorSigma);
  for (std::size_t l = 0; l < sigmas.size() && l < at.state.rings.size(); ++l) {
    const RingCorrections& rings = at.state.rings[l];
    const Eigen::Array3d mean = moments[l] / std::max(1.0, moments[l][0]);
    const double spread = std::sqrt(std::max(1e-12, mean[2] - mean[1] * mean[1]));
    const auto corrected = [](const RingCorrection& ring) { return ring.range != 0.0f; };
    const auto count = std::count_if(rings.begin(), rings.end(), corrected);
    if (count == 0) continue;
    sigmas[l] = TypicalCorrection(rings).range / (spread * std::sqrt(static_cast<double>(count)));
  }
  return sigmas;
}

Prior WidePrior(const LinearizationPoint& at, RangeModel model) {
  const Eigen::Index old = at.layout.calibration;
  const Eigen::Index more = ExtraParameters(at.state.lidars.size());
  Prior prior;
  CalibrationPrior(at.problem, at.state, at.layout, &prior.information, &prior.gradient);
  AddHeldTranslations(at.problem, at.state, &prior.information, &prior.gradient);
  prior.information.conservativeResize(old + more, old + more);
  prior.information.bottomRows(more).setZero();
  prior.information.rightCols(more).setZero();
  prior.information.diagonal().tail(more).setConstant(1.0 / (kPriorSigma * kPriorSigma));
  prior.information.diagonal().tail(kReliefs / 2).setConstant(1.0 / (kHiddenSigma * kHiddenSigma));
  prior.gradient.conservativeResize(old + more);
  prior.gradient.tail(more).setZero();
  if (model != RangeModel::kWhole) return prior;
  const std::vector<double> sigmas = SlopeSigmas(at);
  for (std::size_t l = 0; l < at.state.ranges.size(); ++l) {
    const Eigen::Index slope = old + RangeErrors::Of(l, kRangeSlope);
    prior.information(slope, slope) = 1.0 / (sigmas[l] * sigmas[l]);
    prior.gradient[slope] = at.state.ranges[l].slope * prior.information(slope, slope);
  }
  return prior;
}

// These rows and columns of the inverse, zero where not free.
Eigen::MatrixXd PartOfCovariance(Eigen::MatrixXd information, const std::vector<bool>& free,
                                 Eigen::Index begin, Eigen::Index count) {
  const Eigen::Index size = information.rows();
  HoldFixed(free, &information);
  const Eigen::MatrixXd part = Eigen::MatrixXd::Identity(size, size).middleCols(begin, count);
  Eigen::MatrixXd covariance = SolveSymmetric(information, part).middleRows(begin, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    if (!free[begin + i]) covariance(i, i) = 0.0;
  }
  return covariance;
}

}  // namespace

std::optional<RangeErrors> MeasureRangeErrors(const JointProblem& given, const CalibrationState& state,
                                              RangeModel model, const std::vector<FreeRanges>& free_ranges) {
  const auto any = [](const FreeRanges& f) { return std::find(f.begin(), f.end(), true) != f.end(); };
  const auto walks = [](const FreeRanges& f) { return f[kRangeWalk]; };
  if (given.fix_trajectory || std::none_of(free_ranges.begin(), free_ranges.end(), any)) return std::nullopt;
  std::vector<std::vector<std::size_t>> origins;
  const JointProblem problem = WithShortCouplings(given, state, &origins);
  const Layout layout(state, problem.estimate_imu_matrices);
  const LinearizationPoint at{problem, state, layout};
  std::vector<LandmarkCoupling> couplings;
  Accumulator sum = Linearize(at, &couplings);
  const RangeRow row(at, model);
  AddRanges(at, row, model, &couplings, &sum);
  const Prior prior = WidePrior(at, model);
  std::vector<bool> free = FreeCalibration(problem, layout);
  for (const FreeRanges& f : free_ranges) free.insert(free.end(), f.begin(), f.end());
  free.insert(free.end(), kReliefs, std::any_of(free_ranges.begin(), free_ranges.end(), walks));
  const NormalSolution solution =
      SolveNormalEquations(sum, couplings, prior.information, prior.gradient, free, 0.0, false);
  if (!solution.solved) return std::nullopt;
  const auto count = static_cast<Eigen::Index>(kRangeParameters * free_ranges.size());
  RangeErrors errors;
  const Eigen::VectorXd steps = solution.delta.tail(ExtraParameters(free_ranges.size())).head(count);
  for (Eigen::Index i = 0; i < count; i += kRangeParameters) {
    errors.steps.emplace_back(steps.segment<kRangeParameters>(i));
  }
  errors.references = row.References();
  errors.covariance =
      PartOfCovariance(solution.information + prior.information, free, layout.calibration, count);
  errors.coupling = solution.information.block(0, layout.calibration, layout.calibration, count);
  return errors;
}

std::optional<RangeErrors> MeasureRangeErrorsOfAll(const JointProblem& problem, const CalibrationState& state,
                                                   RangeModel model, const FreeRanges& free) {
  return MeasureRangeErrors(problem, state, model, std::vector<FreeRanges>(state.lidars.size(), free));
}

}  // namespace mlic
