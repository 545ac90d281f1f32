#include "mlic_core/uncertainty/range_corrections.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "mlic_core/geometry/symmetric_matrix.h"
#include "mlic_core/problem/layout.h"
#include "mlic_core/uncertainty/range_draws.h"
#include "mlic_core/uncertainty/range_errors.h"

namespace mlic {
namespace {

// sigmas, which the error itself widens by the correlation that it gives residuals; from: derivation, 3 of
// 1000 normal errors lie beyond
constexpr double kFarFromZero = 3.0;
constexpr double kFlatness = 1e-3;  // m, of what counts as flat; from: guard, walls and their returns
constexpr double kMoves = 0.1;      // of a sigma; from: guard, rounds end where less moves
// Larger errors are not corrected: m, and m for each power of ten; the latter are foliage's, whose depths go
// with its brightness. from: standard, the accuracy that data sheets of LiDARs claim is 1 to 3 cm
constexpr double kLargestError = 0.03;
// Sigma of what LiDARs' offsets err by, m, and their walks, m for each power of ten. from: standard, as the
// largest
constexpr double kUsualError = 0.01;
// Of a walk, where intensities are not quite what the receiver sees, as they fall off with the range in part.
// from: measured, trials, LiDAR, combined effects, open 203: 0.12
constexpr double kShareOfWalk = 0.15;

double SigmaOf(const RangeErrors& errors, std::size_t lidar, RangeParameter parameter, double correlation) {
  const Eigen::Index at = RangeErrors::Of(lidar, parameter);
  return std::sqrt(correlation * errors.covariance(at, at));
}

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

std::optional<RangeErrors> MeasureAll(const JointProblem& problem, const CalibrationState& state,
                                      RangeModel model, const FreeRanges& free) {
  return MeasureRangeErrors(problem, state, model, std::vector<FreeRanges>(state.lidars.size(), free));
}

// Half of what the walks of two kinds of points differ by, of all LiDARs together, beyond what they are
// unsure by, m for each power of ten. model: what the kinds are.
double DifferenceOfWalks(const JointProblem& problem, const CalibrationState& state, RangeModel model,
                         double correlation) {
  const auto parts = MeasureAll(problem, state, model, {true, true, true, true});
  if (!parts) return kUsualError;
  double sum = 0.0, weights = 0.0;
  for (std::size_t l = 0; l < state.lidars.size(); ++l) {
    const double sigma =
        std::hypot(SigmaOf(*parts, l, kRangeWalk, correlation), SigmaOf(*parts, l, kRangeSlope, correlation));
    const double weight = 1.0 / (sigma * sigma);
    sum += weight * (parts->steps[l][kRangeWalk] - parts->steps[l][kRangeSlope]);
    weights += weight;
  }
  const double difference = sum / weights;
  return 0.5 * std::sqrt(std::max(0.0, difference * difference - 1.0 / weights));
}

// What the walks of all LiDARs may err by together, m for each power of ten: planes' own relief need not go
// with the logarithm of their brightness, nor be the same near and far, on the ground and on walls.
double CommonDoubtOfWalks(const JointProblem& problem, const CalibrationState& state, double correlation) {
  double doubt = 0.0;
  for (const RangeModel model : {RangeModel::kByStrength, RangeModel::kByRange, RangeModel::kByLevel}) {
    doubt = std::max(doubt, DifferenceOfWalks(problem, state, model, correlation));
  }
  return doubt;
}

// Whether a walk that was found with this variance is likelier to be a draw of the usual size than nothing.
bool IsLikelierThanNone(double walk, double variance) {
  const double noise = variance + kFlatness * kFlatness, with_walk = noise + kUsualError * kUsualError;
  return walk * walk * (1.0 / noise - 1.0 / with_walk) > std::log(with_walk / noise);
}

// What the planes show of LiDARs' walks: nothing, walks, or what is too large to be one.
enum class ShownWalks { kNone, kSome, kTooLarge };

// Of two LiDARs' difference, as both see what planes themselves have of it, and of each walk by itself, as
// far as it is told from that.
ShownWalks FindWalks(const JointProblem& problem, const CalibrationState& state, double correlation) {
  const auto found = MeasureAll(problem, state, RangeModel::kWhole, {true, false, true, true});
  if (!found) return ShownWalks::kNone;
  const Eigen::MatrixXd& C = found->covariance;
  const double common = CommonDoubtOfWalks(problem, state, correlation);
  ShownWalks shown = ShownWalks::kNone;
  bool differ = false;
  for (std::size_t a = 0; a < state.lidars.size(); ++a) {
    const Eigen::Index at_a = RangeErrors::Of(a, kRangeWalk);
    const double walk = found->steps[a][kRangeWalk];
    if (IsLikelierThanNone(walk, correlation * C(at_a, at_a) + common * common)) {
      const bool too_large = std::abs(walk) >= kLargestError;
      shown = std::max(shown, too_large ? ShownWalks::kTooLarge : ShownWalks::kSome);
    }
    for (std::size_t b = 0; b < a; ++b) {
      const Eigen::Index at_b = RangeErrors::Of(b, kRangeWalk);
      const double difference = walk - found->steps[b][kRangeWalk];
      const double variance = correlation * (C(at_a, at_a) + C(at_b, at_b) - 2.0 * C(at_a, at_b));
      differ |= std::abs(difference) < kLargestError &&
                std::abs(difference) > kFarFromZero * std::hypot(std::sqrt(variance), kFlatness);
    }
  }
  if (differ) return ShownWalks::kSome;  // UsualCorrections sorts out what they share
  return shown;
}

// How all parameters follow when the walk of one LiDAR moves and the others' stay: a column for each.
Eigen::MatrixXd FollowingWalks(const RangeErrors& found) {
  const auto lidars = static_cast<Eigen::Index>(found.steps.size());
  const auto walk = [](Eigen::Index l) { return RangeErrors::Of(static_cast<std::size_t>(l), kRangeWalk); };
  Eigen::MatrixXd with_walks(found.covariance.rows(), lidars), of_walks(lidars, lidars);
  for (Eigen::Index l = 0; l < lidars; ++l) with_walks.col(l) = found.covariance.col(walk(l));
  for (Eigen::Index l = 0; l < lidars; ++l) of_walks.row(l) = with_walks.row(walk(l));
  return SolveSymmetric(of_walks, Eigen::MatrixXd(with_walks.transpose())).transpose();
}

// With what the walks of all LiDARs may err by together, all else following.
Eigen::MatrixXd CovarianceWithCommonWalk(const JointProblem& problem, const CalibrationState& state,
                                         const RangeErrors& found, double correlation) {
  const Eigen::VectorXd common =
      CommonDoubtOfWalks(problem, state, correlation) * FollowingWalks(found).rowwise().sum();
  return correlation * found.covariance + common * common.transpose();
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

// The same of LiDARs that err as usual, where what all walks share is as unsure as strong and weak echoes
// differ in it, and offsets with it: the mean given both.
Corrections UsualCorrections(const JointProblem& problem, const CalibrationState& state,
                             const RangeErrors& found, double correlation) {
  constexpr double kAny = 1.0;  // m, m/rad; from: structural, no prior
  Eigen::VectorXd usual = Eigen::VectorXd::Constant(found.covariance.rows(), kAny);
  for (std::size_t l = 0; l < found.steps.size(); ++l) {
    for (const RangeParameter p : {kRangeOffset, kRangeWalk}) usual[RangeErrors::Of(l, p)] = kUsualError;
  }
  const Eigen::MatrixXd prior = usual.cwiseAbs2().asDiagonal();
  const Eigen::MatrixXd covariance = CovarianceWithCommonWalk(problem, state, found, correlation);
  Corrections corrections = CorrectionsOf(state, found, correlation);
  corrections.values = prior * SolveSymmetric(prior + covariance, corrections.values);
  corrections.sigmas = covariance.diagonal().cwiseSqrt();
  return corrections;
}

// What corrected walks may err by beyond their covariance, as moves of the gradient: a column for each LiDAR,
// by what is its own, and one for what all share.
Eigen::MatrixXd DoubtOfWalks(const JointProblem& problem, const CalibrationState& state,
                             const RangeErrors& found, const Eigen::MatrixXd& coupling, double correlation) {
  const Eigen::MatrixXd moved_by = coupling * FollowingWalks(found);
  const auto lidars = static_cast<double>(state.lidars.size());
  double mean = 0.0;
  for (const RangeCorrection& ranges : state.ranges) mean += ranges.walk / lidars;
  Eigen::MatrixXd doubt(moved_by.rows(), moved_by.cols() + 1);
  for (Eigen::Index l = 0; l < moved_by.cols(); ++l) {
    const double own = state.ranges[static_cast<std::size_t>(l)].walk - mean;
    doubt.col(l) = kShareOfWalk * own * moved_by.col(l);
  }
  const double common = CommonDoubtOfWalks(problem, state, correlation);
  doubt.rightCols<1>() = common * kUsualError / std::hypot(common, kUsualError) * moved_by.rowwise().sum();
  return doubt;
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
  if (!walks && !*walks_dropped) {
    const ShownWalks shown = FindWalks(problem, *state, correlation);
    walks = shown == ShownWalks::kSome;
    *walks_dropped = shown == ShownWalks::kTooLarge;
  }
  std::vector<bool> offsets = WhichHaveOffsets(*state);
  const auto parts = MeasureAll(problem, *state, RangeModel::kByIncidence, {true, true, walks, true});
  if (!parts) return false;
  for (std::size_t l = 0; l < offsets.size(); ++l) {
    if (ConfirmedOffset(*parts, l, correlation) != 0.0) offsets[l] = true;
  }
  std::vector<FreeRanges> free = FreeOfCorrected(*state, walks, offsets);
  auto found = MeasureRangeErrors(problem, *state, RangeModel::kWhole, free);
  if (!found) return false;
  bool moved = false;
  if (!walks && DropLargeOffsets(*found, *state, &offsets)) {
    for (std::size_t l = 0; l < offsets.size(); ++l) {
      if (offsets[l] || !HasOffset(*state, l)) continue;
      state->ranges[l] = {};
      moved = true;
    }
    free = FreeOfCorrected(*state, walks, offsets);
    found = MeasureRangeErrors(problem, *state, RangeModel::kWhole, free);
    if (!found) return moved;
  }
  const Corrections corrections = walks ? UsualCorrections(problem, *state, *found, correlation)
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
  const auto parts = MeasureAll(problem, state, RangeModel::kByIncidence, {true, true, walks, true});
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
  const auto found = MeasureRangeErrors(problem, state, RangeModel::kWhole, free);
  const Eigen::Index size = Layout(state, problem.estimate_imu_matrices).calibration;
  if (!found) return Eigen::MatrixXd::Zero(size, size);
  const Eigen::MatrixXd& coupling = found->coupling;
  const Eigen::MatrixXd covariance = drawn_walks
                                         ? CovarianceWithCommonWalk(problem, state, *found, correlation)
                                         : Eigen::MatrixXd(correlation * found->covariance);
  Eigen::MatrixXd square = MeanSquareOfRangeErrors(*found, draws, covariance, kLargestError);
  if (walks) square = CorrectedAndLevel(covariance, square);
  Eigen::MatrixXd scatter = coupling * square / correlation * coupling.transpose();
  if (walks || walks_dropped) {
    const Eigen::MatrixXd doubt =
        walks ? DoubtOfWalks(problem, state, *found, coupling, correlation) : DoubtOfDroppedWalks(*found);
    scatter += doubt * doubt.transpose() / correlation;
  }
  return scatter;
}

}  // namespace mlic
