#include "mlic_core/uncertainty/range_walks.h"

#include <algorithm>
#include <optional>

#include "mlic_core/geometry/symmetric_matrix.h"

namespace mlic {
namespace {

// Half of a difference, beyond what it is unsure by.
double HalfBeyond(double difference, double variance) {
  return 0.5 * std::sqrt(std::max(0.0, difference * difference - variance));
}

// Half of what the walks of two kinds of points differ by, beyond what they are unsure by. model: what the
// kinds are.
DoubtOfWalks DifferenceOfWalks(const RangeEquations& equations, RangeModel model, double correlation) {
  const auto lidars = static_cast<Eigen::Index>(equations.LidarCount());
  const auto parts = equations.MeasureOfAll(model, {true, true, true, true});
  if (!parts) return {kUsualError, Eigen::VectorXd::Zero(lidars)};
  // Of each LiDAR, the difference as a function of all parameters.
  Eigen::MatrixXd differences = Eigen::MatrixXd::Zero(lidars, parts->covariance.rows());
  Eigen::VectorXd found(lidars), weights(lidars);
  for (Eigen::Index l = 0; l < lidars; ++l) {
    const auto lidar = static_cast<std::size_t>(l);
    differences(l, RangeErrors::Of(lidar, kRangeWalk)) = 1.0;
    differences(l, RangeErrors::Of(lidar, kRangeSlope)) = -1.0;
    found[l] = parts->steps[lidar][kRangeWalk] - parts->steps[lidar][kRangeSlope];
    const double sigma = std::hypot(parts->Sigma(lidar, kRangeWalk, correlation),
                                    parts->Sigma(lidar, kRangeSlope, correlation));
    weights[l] = 1.0 / (sigma * sigma);
  }
  DoubtOfWalks doubt{HalfBeyond(weights.dot(found) / weights.sum(), 1.0 / weights.sum()),
                     Eigen::VectorXd::Zero(lidars)};
  if (lidars < 2) return doubt;
  const auto count = static_cast<double>(lidars);
  const Eigen::MatrixXd beside =
      Eigen::MatrixXd::Identity(lidars, lidars) - Eigen::MatrixXd::Constant(lidars, lidars, 1.0 / count);
  const Eigen::MatrixXd own = beside * differences;
  const Eigen::VectorXd variances = correlation * (own * parts->covariance * own.transpose()).diagonal();
  // Of independent errors, less the mean of all of them, this share is left.
  const double left = std::sqrt(1.0 - 1.0 / count);
  for (Eigen::Index l = 0; l < lidars; ++l) {
    doubt.own[l] = HalfBeyond(beside.row(l).dot(found), variances[l]) / left;
  }
  return doubt;
}

// Whether a walk, or a difference of two, that was found with this variance is likelier to be of the usual
// size than nothing. walks: how many.
bool IsLikelierThanNone(double found, double variance, int walks) {
  const double noise = variance + kFlatness * kFlatness,
               with_walk = noise + walks * kUsualError * kUsualError;
  return found * found * (1.0 / noise - 1.0 / with_walk) > std::log(with_walk / noise);
}

}  // namespace

Eigen::VectorXd DoubtOfWalks::Beside() const {
  // from: measured, trials, LiDAR, open 547, 549, 551, 555 and 565: with it mean z^2 of differences is 0.9 (7
  // of them; without, 2.6)
  constexpr double kShareSeenUnlike = 0.1;
  if (own.size() < 2) return own;
  return (own.array().square() + std::pow(kShareSeenUnlike * common, 2)).sqrt();
}

DoubtOfWalks MeasureDoubtOfWalks(const RangeEquations& equations, double correlation) {
  DoubtOfWalks doubt{0.0, Eigen::VectorXd::Zero(static_cast<Eigen::Index>(equations.LidarCount()))};
  for (const RangeModel model : {RangeModel::kByStrength, RangeModel::kByRange, RangeModel::kByLevel}) {
    const DoubtOfWalks by = DifferenceOfWalks(equations, model, correlation);
    doubt.common = std::max(doubt.common, by.common);
    doubt.own = doubt.own.cwiseMax(by.own);
  }
  return doubt;
}

ShownWalks FindWalks(const RangeEquations& equations, const DoubtOfWalks& doubt, double correlation) {
  const auto found = equations.MeasureOfAll(RangeModel::kWhole, {true, false, true, true});
  if (!found) return ShownWalks::kNone;
  const Eigen::MatrixXd& C = found->covariance;
  ShownWalks shown = ShownWalks::kNone;
  bool differ = false;
  for (std::size_t a = 0; a < equations.LidarCount(); ++a) {
    const Eigen::Index at_a = RangeErrors::Of(a, kRangeWalk);
    const double walk = found->steps[a][kRangeWalk];
    if (IsLikelierThanNone(walk, correlation * C(at_a, at_a) + std::pow(doubt.Of(a), 2), 1)) {
      const bool too_large = std::abs(walk) >= kLargestError;
      shown = std::max(shown, too_large ? ShownWalks::kTooLarge : ShownWalks::kSome);
    }
    for (std::size_t b = 0; b < a; ++b) {
      const Eigen::Index at_b = RangeErrors::Of(b, kRangeWalk);
      const double difference = walk - found->steps[b][kRangeWalk];
      const double variance = correlation * (C(at_a, at_a) + C(at_b, at_b) - 2.0 * C(at_a, at_b));
      differ |= std::abs(difference) < kLargestError &&
                IsLikelierThanNone(difference, variance + std::pow(doubt.OfDifference(a, b), 2), 2);
    }
  }
  if (differ) return ShownWalks::kSome;  // UsualCorrections sorts out what they share
  return shown;
}

Eigen::MatrixXd FollowingWalks(const RangeErrors& found) {
  const auto lidars = static_cast<Eigen::Index>(found.steps.size());
  const auto walk = [](Eigen::Index l) { return RangeErrors::Of(static_cast<std::size_t>(l), kRangeWalk); };
  Eigen::MatrixXd with_walks(found.covariance.rows(), lidars), of_walks(lidars, lidars);
  for (Eigen::Index l = 0; l < lidars; ++l) with_walks.col(l) = found.covariance.col(walk(l));
  for (Eigen::Index l = 0; l < lidars; ++l) of_walks.row(l) = with_walks.row(walk(l));
  return SolveSymmetric(of_walks, Eigen::MatrixXd(with_walks.transpose())).transpose();
}

Eigen::MatrixXd CovarianceWithDoubtOfWalks(const RangeErrors& found, const DoubtOfWalks& doubt,
                                           double correlation) {
  const Eigen::MatrixXd following = FollowingWalks(found);
  const Eigen::VectorXd common = doubt.common * following.rowwise().sum();
  const Eigen::MatrixXd own = following * doubt.Beside().asDiagonal();
  return correlation * found.covariance + common * common.transpose() + own * own.transpose();
}

}  // namespace mlic
