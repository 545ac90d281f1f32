#include "mlic_core/uncertainty/range_corrections.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "mlic_core/geometry/symmetric_matrix.h"
#include "mlic_core/problem/layout.h"
#include "mlic_core/uncertainty/range_draws.h"
#include "mlic_core/uncertainty/range_errors.h"
#include "mlic_core/uncertainty/range_walks.h"

namespace mlic {
namespace {

constexpr double kMoves = 0.1;  // of a sigma; from: guard, rounds end where less moves
// Of a walk, where intensities are not quite what the receiver sees, as they fall off with the range in part.
// from: measured, trials, LiDAR, combined effects, open 203: 0.12
constexpr double kShareOfWalk = 0.15;

// The offset that points which meet planes steeply and others both show, or 0. parts: by incidence.
double ConfirmedOffset(const RangeErrors& parts, std::size_t lidar, double correlation) {
  const Eigen::Vector2d both(parts.steps[lidar][kRangeOffset], parts.steps[lidar][kRangeSlope]);
  if (std::abs(both[0] - both[1]) >= both.cwiseAbs().minCoeff()) return 0.0;
  const Eigen::Index begin = RangeErrors::Of(lidar, kRangeOffset);
  static_assert(kRangeSlope == kRangeOffset + 1);
  const Eigen::Matrix2d covariance = correlation * parts.covariance.block<2, 2>(begin, begin);
  const Eigen::Vector2d weights = SolveSymmetric(covariance, Eigen::Vector2d::Ones());
  const double offset = weights.dot(both) / weights.sum();
  const double sigma = std::hypot(std::sqrt(1.0 / weights.sum()), kFlatness);
  return std::abs(offset) > kFarFromZero * sigma ? offset : 0.0;
}

bool HasOffset(const CalibrationState& state, std::size_t lidar) {
  return lidar < state.ranges.size() && state.ranges[lidar].offset != 0.0;
}

bool AnyWalkCorrected(const CalibrationState& state) {
  return std::any_of(state.ranges.begin(), state.ranges.end(),
                     [](const RangeCorrection& ranges) { return ranges.walk != 0.0; });
}

bool AnyWalkTooLarge(const CalibrationState& state) {
  return std::any_of(state.ranges.begin(), state.ranges.end(),
                     [](const RangeCorrection& ranges) { return std::abs(ranges.walk) > kLargestError; });
}

// What is found of LiDARs whose ranges are corrected.
std::vector<FreeRanges> FreeOfCorrected(const CalibrationState& state, bool walks,
                                        const std::vector<bool>& offsets) {
  std::vector<FreeRanges> free(state.lidars.size(), FreeRanges{});
  for (std::size_t l = 0; l < free.size(); ++l) {
    const bool rings = l < state.rings.size() && !state.rings[l].empty();
    free[l][kRangeOffset] = offsets[l] || walks;
    free[l][kRangeSlope] = (offsets[l] || walks) && rings;
    free[l][kRangeWalk] = walks;
    free[l][kRangeLevel] = offsets[l] || walks;
  }
  return free;
}

std::vector<bool> WhichHaveOffsets(const CalibrationState& state) {
  std::vector<bool> offsets;
  for (std::size_t l = 0; l < state.lidars.size(); ++l) offsets.push_back(HasOffset(state, l));
  return offsets;
}

// Whether any LiDAR tells how strong its echoes are; without that, no walk is told from an offset.
bool AnyIntensities(const JointProblem& problem) {
  for (const DriveTerms& drive : problem.drives) {
    const std::vector<PlaneObservation>& all = drive.planes.observations;
    if (std::any_of(all.begin(), all.end(), [](const auto& o) { return o.intensity > 0.0f; })) return true;
  }
  return false;
}

RangeVector VectorOf(const RangeCorrection& ranges) {
  RangeVector vector;
  vector << ranges.offset, ranges.slope, ranges.walk, 0.0;
  return vector;
}

// What is added to ranges (RangeErrors::Of).
struct Corrections {
  Eigen::VectorXd values, sigmas;
};

// As `found` has it.
Corrections CorrectionsOf(const CalibrationState& state, const RangeErrors& found, double correlation) {
  Corrections corrections{Eigen::VectorXd(found.covariance.rows()),
                          (correlation * found.covariance.diagonal()).cwiseSqrt()};
  for (std::size_t l = 0; l < found.steps.size(); ++l) {
    corrections.values.segment<kRangeParameters>(RangeErrors::Of(l, kRangeOffset)) =
        VectorOf(state.ranges[l]) + found.steps[l];
  }
  return corrections;
}

// The same of LiDARs that err as usual, where walks are doubted, and offsets with them: the mean given both.
Corrections UsualCorrections(const CalibrationState& state, const RangeErrors& found,
                             const DoubtOfWalks& doubt, double correlation) {
  constexpr double kAny = 1.0;  // m, m/rad; from: structural, no prior
  Eigen::VectorXd usual = Eigen::VectorXd::Constant(found.covariance.rows(), kAny);
  for (std::size_t l = 0; l < found.steps.size(); ++l) {
    for (const RangeParameter p : {kRangeOffset, kRangeWalk}) usual[RangeErrors::Of(l, p)] = kUsualError;
  }
  const Eigen::MatrixXd prior = usual.cwiseAbs2().asDiagonal();
  const Eigen::MatrixXd covariance = CovarianceWithDoubtOfWalks(found, doubt, correlation);
  Corrections corrections = CorrectionsOf(state, found, correlation);
  corrections.values = prior * SolveSymmetric(prior + covariance, corrections.values);
  corrections.sigmas = covariance.diagonal().cwiseSqrt();
  return corrections;
}

// What corrected walks may err by beyond their covariance, as moves of the gradient: a column for each LiDAR,
// by what is its own, and one for what all share.
Eigen::MatrixXd DoubtOfCorrectedWalks(const CalibrationState& state, const RangeErrors& found,
                                      const Eigen::MatrixXd& coupling, const DoubtOfWalks& doubt) {
  const Eigen::MatrixXd moved_by = coupling * FollowingWalks(found);
  const auto lidars = static_cast<double>(state.lidars.size());
  double mean = 0.0;
  for (const RangeCorrection& ranges : state.ranges) mean += ranges.walk / lidars;
  const auto of_usual = [](double sigma) { return sigma * kUsualError / std::hypot(sigma, kUsualError); };
  const Eigen::VectorXd beside = doubt.Beside();
  Eigen::MatrixXd moves(moved_by.rows(), moved_by.cols() + 1);
  for (Eigen::Index l = 0; l < moved_by.cols(); ++l) {
    const double own = state.ranges[static_cast<std::size_t>(l)].walk - mean;
    moves.col(l) = std::hypot(kShareOfWalk * own, of_usual(beside[l])) * moved_by.col(l);
  }
  moves.rightCols<1>() = of_usual(doubt.common) * moved_by.rowwise().sum();
  return moves;
}

// What walks that stay uncorrected may err by, as moves of the gradient: a column for each LiDAR.
Eigen::MatrixXd DoubtOfDroppedWalks(const RangeErrors& found) {
  const auto lidars = static_cast<Eigen::Index>(found.steps.size());
  Eigen::MatrixXd doubt(found.coupling.rows(), lidars);
  for (Eigen::Index l = 0; l < lidars; ++l) {
    doubt.col(l) = kUsualError * found.coupling.col(RangeErrors::Of(static_cast<std::size_t>(l), kRangeWalk));
  }
  return doubt;
}

// Takes those off the offsets that are larger than LiDARs err by. True if there are any.
bool DropLargeOffsets(const RangeErrors& found, const CalibrationState& state, std::vector<bool>* offsets) {
  bool any = false;
  for (std::size_t l = 0; l < offsets->size(); ++l) {
    const double offset = state.ranges[l].offset + found.steps[l][kRangeOffset];
    if (!(*offsets)[l] || std::abs(offset) < kLargestError) continue;
    (*offsets)[l] = false;
    any = true;
  }
  return any;
}

// Mean square of ranges' errors where all but those of level planes are corrected, and that beside any such
// errors: as unsure as they were found, whatever the level planes' are likely to be.
Eigen::MatrixXd CorrectedAndLevel(const Eigen::MatrixXd& of_corrected, const Eigen::MatrixXd& of_level) {
  Eigen::MatrixXd square = of_corrected;
  for (Eigen::Index a = kRangeLevel; a < square.rows(); a += kRangeParameters) {
    square.row(a).setZero();
    square.col(a).setZero();
  }
  for (Eigen::Index a = kRangeLevel; a < square.rows(); a += kRangeParameters) {
    for (Eigen::Index b = kRangeLevel; b < square.rows(); b += kRangeParameters)
      square(a, b) = of_level(a, b);
  }
  return square;
}

}  // namespace

bool AnyRangeCorrected(const CalibrationState& state) {
  for (std::size_t l = 0; l < state.lidars.size(); ++l) {
    if (HasOffset(state, l)) return true;
  }
  return false;
}

std::ptrdiff_t CountCorrections(const CalibrationState& state) {
  std::ptrdiff_t count = std::count_if(state.rings.begin(), state.rings.end(),
                                       [](const RingCorrections& rings) { return !rings.empty(); });
  for (const RangeCorrection& ranges : state.ranges) count += (ranges.offset != 0.0) + (ranges.walk != 0.0);
  return count;
}

bool CorrectRanges(const JointProblem& problem, double correlation, bool* walks_dropped,
                   CalibrationState* state) {
  state->ranges.resize(state->lidars.size());
  if (AnyWalkTooLarge(*state)) {
    *walks_dropped = true;
    state->ranges.assign(state->lidars.size(), {});
    return true;
  }
  bool walks = AnyWalkCorrected(*state);
  const RangeEquations equations(problem, *state);
  DoubtOfWalks doubt;
  if (walks || !*walks_dropped) doubt = MeasureDoubtOfWalks(equations, correlation);
  if (!walks && !*walks_dropped) {
    const ShownWalks shown = FindWalks(equations, doubt, correlation);
    walks = shown == ShownWalks::kSome;
    *walks_dropped = shown == ShownWalks::kTooLarge;
  }
  std::vector<bool> offsets = WhichHaveOffsets(*state);
  const auto parts = equations.MeasureOfAll(RangeModel::kByIncidence, {true, true, walks, true});
  if (!parts) return false;
  for (std::size_t l = 0; l < offsets.size(); ++l) {
    if (ConfirmedOffset(*parts, l, correlation) != 0.0) offsets[l] = true;
  }
  std::vector<FreeRanges> free = FreeOfCorrected(*state, walks, offsets);
  auto found = equations.Measure(RangeModel::kWhole, free);
  if (!found) return false;
  bool moved = false;
  if (!walks && DropLargeOffsets(*found, *state, &offsets)) {
    for (std::size_t l = 0; l < offsets.size(); ++l) {
      if (offsets[l] || !HasOffset(*state, l)) continue;
      state->ranges[l] = {};
      moved = true;
    }
    free = FreeOfCorrected(*state, walks, offsets);
    found = RangeEquations(problem, *state).Measure(RangeModel::kWhole, free);
    if (!found) return moved;
  }
  const Corrections corrections = walks ? UsualCorrections(*state, *found, doubt, correlation)
                                        : CorrectionsOf(*state, *found, correlation);
  for (std::size_t l = 0; l < free.size(); ++l) {
    RangeCorrection& ranges = state->ranges[l];
    const RangeVector before = VectorOf(ranges);
    const Eigen::Index begin = RangeErrors::Of(l, kRangeOffset);
    RangeVector now = corrections.values.segment<kRangeParameters>(begin);
    for (const RangeParameter p : {kRangeOffset, kRangeSlope, kRangeWalk}) {
      // A slope ends with the rings' corrections that it goes with.
      if (!free[l][p]) now[p] = 0.0;
      moved |= std::abs(now[p] - before[p]) > (free[l][p] ? kMoves * corrections.sigmas[begin + p] : 0.0);
    }
    ranges.offset = now[kRangeOffset];
    ranges.slope = now[kRangeSlope];
    ranges.walk = now[kRangeWalk];
    if (walks) ranges.reference = found->references[l];
  }
  return moved;
}

std::vector<double> ApparentOffsets(const JointProblem& problem, const CalibrationState& state,
                                    double correlation) {
  std::vector<double> offsets;
  for (std::size_t l = 0; l < state.lidars.size(); ++l) {
    offsets.push_back(l < state.ranges.size() ? state.ranges[l].offset : 0.0);
  }
  const bool walks = AnyWalkCorrected(state);
  const auto parts =
      RangeEquations(problem, state).MeasureOfAll(RangeModel::kByIncidence, {true, true, walks, true});
  for (std::size_t l = 0; parts && l < offsets.size(); ++l) {
    offsets[l] += ConfirmedOffset(*parts, l, correlation);
  }
  return offsets;
}

Eigen::MatrixXd ScatterOfRanges(const JointProblem& problem, const CalibrationState& state,
                                double correlation, bool walks_dropped) {
  const bool walks = AnyWalkCorrected(state);
  std::vector<FreeRanges> free = FreeOfCorrected(state, walks, WhichHaveOffsets(state));
  const bool drawn_walks = !walks && !walks_dropped && AnyIntensities(problem);
  std::vector<FreeRanges> draws(free.size(), FreeRanges{});
  for (std::size_t l = 0; l < free.size(); ++l) {
    draws[l][kRangeOffset] = !free[l][kRangeOffset];
    draws[l][kRangeWalk] = drawn_walks;
    draws[l][kRangeLevel] = true;
    for (const RangeParameter p : {kRangeOffset, kRangeWalk, kRangeLevel}) free[l][p] |= draws[l][p];
  }
  const RangeEquations equations(problem, state);
  const auto found = equations.Measure(RangeModel::kWhole, free);
  const Eigen::Index size = Layout(state, problem.estimate_imu_matrices).calibration;
  if (!found) return Eigen::MatrixXd::Zero(size, size);
  DoubtOfWalks doubt;
  if (walks || drawn_walks) doubt = MeasureDoubtOfWalks(equations, correlation);
  const Eigen::MatrixXd& coupling = found->coupling;
  const Eigen::MatrixXd covariance = drawn_walks ? CovarianceWithDoubtOfWalks(*found, doubt, correlation)
                                                 : Eigen::MatrixXd(correlation * found->covariance);
  Eigen::MatrixXd square = MeanSquareOfRangeErrors(*found, draws, covariance, kLargestError);
  if (walks) square = CorrectedAndLevel(covariance, square);
  Eigen::MatrixXd scatter = coupling * square / correlation * coupling.transpose();
  if (walks || walks_dropped) {
    const Eigen::MatrixXd moves =
        walks ? DoubtOfCorrectedWalks(state, *found, coupling, doubt) : DoubtOfDroppedWalks(*found);
    scatter += moves * moves.transpose() / correlation;
  }
  return scatter;
}

}  // namespace mlic
