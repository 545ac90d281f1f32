#include "mlic_core/uncertainty/split_halves.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <utility>

#include "mlic_core/common/significance.h"
#include "mlic_core/geometry/symmetric_matrix.h"
#include "mlic_core/problem/inverse_in_limits.h"
#include "mlic_core/problem/noise_information.h"
#include "mlic_core/uncertainty/half_calibration.h"
#include "mlic_core/uncertainty/intrinsics_observability.h"
#include "mlic_core/uncertainty/stamp_errors.h"

namespace mlic {
namespace {

using Quantity = HalvesDifference::Quantity;

// What two parts say of each calibration parameter (Layout).
struct Compared {
  Eigen::VectorXd difference;
  Eigen::MatrixXd covariance;                         // of the difference
  Eigen::MatrixXd first_from_data, second_from_data;  // covariances of the parts without the guesses
  std::vector<bool> free_calibration;
  Eigen::VectorXd limits;
};

// growth: of both parts together, as few groups of observations are in one. share: of the whole's
// information.
Inflation InflationOf(const Adjustment& adjustment, const HalfCalibration& half,
                      const Eigen::VectorXd& growth, double share) {
  Inflation inflation{half.cameras, share * adjustment.scale.inflation.points};
  inflation.cameras.growth = growth;
  inflation.cameras.relations.clear();  // are not compared
  inflation.cameras.pattern.setZero();  // the same in both
  return inflation;
}

// Adds a half's own error to the covariance of the difference. Returns how its calibration follows the
// priors' gradient.
Eigen::MatrixXd AddHalf(const HalfCalibration& half, double scale, Inflation inflation, Compared* compared,
                        Eigen::MatrixXd* from_data) {
  const Eigen::VectorXd& limits = compared->limits;
  Eigen::MatrixXd information = half.information;
  if (half.noise.size() > 0) {
    const std::vector<bool>& free = compared->free_calibration;
    const FreedOfNoise freed = WithoutNoise(information, WithoutFixed(half.noise, free), limits);
    information = WithoutFixed(freed.information, free);
    inflation = WithGradient(freed.by_gradient, std::move(inflation));
  }
  information /= scale;
  const Eigen::MatrixXd gain = InverseInLimits(information + half.prior, limits);
  compared->covariance += gain * information * gain + VarianceOfInflation(gain, inflation, scale);
  const Eigen::MatrixXd alone = InverseInLimits(information + half.prior - half.guesses, limits);
  *from_data = alone + VarianceOfInflation(alone, inflation, scale);
  return gain;
}

// CovarianceScale::correlation as the halves have it, and no larger than the whole's.
double CorrelationOf(const Adjustment& adjustment, const HalfCalibration& first,
                     const HalfCalibration& second) {
  double correlation = 0.5 * (first.correlation + second.correlation);
  StampSums stamps = first.stamps;
  stamps.insert(stamps.end(), second.stamps.begin(), second.stamps.end());
  const std::vector<StampErrors> errors = JudgeStampErrors(stamps);
  for (std::size_t l = 0; l < adjustment.state.lidars.size(); ++l) {
    correlation = std::max(correlation, errors[l].excess);
  }
  return std::min(correlation, adjustment.scale.correlation);
}

double InformationOf(const HalfCalibration& half, const Eigen::VectorXd& limits) {
  return half.information.diagonal().dot(limits.cwiseAbs2());
}

// of_whole: InformationOf both halves.
Compared Compare(const Adjustment& adjustment, const HalfCalibration& first, const HalfCalibration& second,
                 double of_whole, double scale) {
  const Layout layout(adjustment.state, adjustment.problem.estimate_imu_matrices);
  Compared compared;
  compared.limits = CalibrationLimits(adjustment.state, layout);
  compared.free_calibration = FreeCalibration(adjustment.problem, layout);
  compared.difference = second.moved - first.moved;
  compared.covariance = Eigen::MatrixXd::Zero(layout.calibration, layout.calibration);
  const auto share_of = [&](const HalfCalibration& part) {
    return InformationOf(part, compared.limits) / std::max(1e-300, of_whole);
  };
  const double of_first = share_of(first), of_second = share_of(second);
  const Eigen::VectorXd growth =
      first.cameras.IsEmpty() || second.cameras.IsEmpty()
          ? Eigen::VectorXd()
          : (0.5 * (first.cameras.growth.cwiseAbs2() + second.cameras.growth.cwiseAbs2())).cwiseSqrt().eval();
  const Eigen::MatrixXd by_first = AddHalf(first, scale, InflationOf(adjustment, first, growth, of_first),
                                           &compared, &compared.first_from_data);
  const Eigen::MatrixXd by_second = AddHalf(second, scale, InflationOf(adjustment, second, growth, of_second),
                                            &compared, &compared.second_from_data);
  compared.covariance *= CorrelationOf(adjustment, first, second) / adjustment.scale.correlation;
  // The priors err alike in both: only what the parts follow them differently by is left.
  const Eigen::MatrixXd unlike = by_first - by_second;
  compared.covariance += unlike * first.prior * unlike;
  return compared;
}

Eigen::MatrixXd Chosen(const Eigen::MatrixXd& matrix, const std::vector<int>& places,
                       const Eigen::VectorXd& limits) {
  const auto count = static_cast<Eigen::Index>(places.size());
  Eigen::MatrixXd chosen(count, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    for (Eigen::Index k = 0; k < count; ++k) {
      chosen(i, k) = matrix(places[i], places[k]) / (limits[i] * limits[k]);
    }
  }
  return chosen;
}

// The unit vectors (columns) along which both covariances, in limits, stay within them: the eigenvectors of
// their sum.
Eigen::MatrixXd ShownDirections(const Eigen::MatrixXd& first, const Eigen::MatrixXd& second) {
  const SymmetricEigen<Eigen::Dynamic> eigen(first + second);
  Eigen::MatrixXd shown(first.rows(), 0);
  for (Eigen::Index i = 0; i < first.rows(); ++i) {
    const Eigen::VectorXd direction = eigen.eigenvectors().col(i);
    if (!(direction.dot(first * direction) <= 1.0 && direction.dot(second * direction) <= 1.0)) continue;
    shown.conservativeResize(Eigen::NoChange, shown.cols() + 1);
    shown.rightCols<1>() = direction;
  }
  return shown;
}

// Of the parameters at these places, whose limits may be narrower than the calibration's.
std::optional<HalvesDifference> CompareAt(const Compared& compared, Quantity quantity,
                                          const std::vector<int>& places, const Eigen::VectorXd& limits) {
  if (places.empty()) return std::nullopt;
  const Eigen::MatrixXd first = Chosen(compared.first_from_data, places, limits);
  const Eigen::MatrixXd second = Chosen(compared.second_from_data, places, limits);
  const Eigen::MatrixXd covariance = Chosen(compared.covariance, places, limits);
  if (!first.allFinite() || !second.allFinite() || !covariance.allFinite()) return std::nullopt;
  const Eigen::MatrixXd shown = ShownDirections(first, second);
  if (shown.cols() == 0) return std::nullopt;
  HalvesDifference result;
  result.quantity = quantity;
  Eigen::VectorXd difference(first.rows());
  for (Eigen::Index i = 0; i < first.rows(); ++i) {
    difference[i] = compared.difference[places[i]] / limits[i];
    const double sigma = std::sqrt(std::max(0.0, covariance(i, i)));
    const bool is_shown = first(i, i) <= 1.0 && second(i, i) <= 1.0 && sigma > 0.0;
    result.difference.push_back(difference[i] * limits[i]);
    result.sigma.push_back(is_shown ? sigma * limits[i] : 0.0);
    if (is_shown) result.largest = std::max(result.largest, std::abs(difference[i]) / sigma);
  }
  result.directions = static_cast<int>(shown.cols());
  const Eigen::VectorXd along = shown.transpose() * difference;
  result.squares = std::max(0.0, SquaredMahalanobis(shown.transpose() * covariance * shown, along));
  result.deviation = EquivalentDeviation(result.squares, result.directions);
  return result;
}

std::vector<int> FreeOf(const std::vector<bool>& free_calibration, int begin, int count) {
  std::vector<int> places;
  for (int i = begin; i < begin + count; ++i) {
    if (free_calibration[static_cast<std::size_t>(i)]) places.push_back(i);
  }
  return places;
}

// A direction that the guess says better than the data is not the data's.
Eigen::VectorXd WithGuess(Eigen::VectorXd limits, const Eigen::Vector3d* guess_sigma) {
  if (guess_sigma != nullptr && limits.size() == 3) limits = limits.cwiseMin(*guess_sigma);
  return limits;
}

SensorHalves CompareSensor(const Adjustment& adjustment, const Layout& layout, const Compared& compared,
                           SensorId id) {
  SensorHalves sensor;
  const std::optional<ExtrinsicGuess>& guess = GuessOf(id, adjustment.problem);
  const auto add = [&](Quantity quantity, const std::vector<int>& places, const Eigen::Vector3d* sigma) {
    Eigen::VectorXd limits(static_cast<Eigen::Index>(places.size()));
    for (Eigen::Index i = 0; i < limits.size(); ++i) limits[i] = compared.limits[places[i]];
    const auto found = CompareAt(compared, quantity, places, WithGuess(limits, sigma));
    if (found) sensor.quantities.push_back(*found);
  };
  const std::vector<bool>& free = compared.free_calibration;
  const int pose = Layout::Sensor(layout.order.PlaceOf(id));
  add(Quantity::kRotation, FreeOf(free, pose, 3), guess ? &guess->sigma_rotation : nullptr);
  add(Quantity::kTranslation, FreeOf(free, pose + 3, 3), guess ? &guess->sigma_translation : nullptr);
  add(Quantity::kTimeOffset, FreeOf(free, pose + 6, 1), nullptr);
  if (id.IsLidar()) return sensor;
  const std::size_t c = id.index;
  const auto count = static_cast<int>(adjustment.state.cameras[c].intrinsics.parameters.size());
  std::vector<int> lens = FreeOf(free, layout.Intrinsics(c), count);
  if (layout.Readout(c) >= 0 && free[static_cast<std::size_t>(layout.Readout(c))]) {
    lens.push_back(layout.Readout(c));
  }
  add(Quantity::kIntrinsics, lens, nullptr);
  return sensor;
}

}  // namespace

Halves CutByTurning(const CalibrationState& state, double share) {
  constexpr double kStep = 0.05;  // s; from: structural, finer than turns
  std::vector<double> turned{0.0};
  struct Place {
    std::size_t drive;
    double time;
  };
  std::vector<Place> places;
  for (std::size_t d = 0; d < state.drives.size(); ++d) {
    const SplitSpline& trajectory = state.drives[d].trajectory;
    for (double t = trajectory.Start(); t < trajectory.End(); t += kStep) {
      turned.push_back(turned.back() + trajectory.rotation.AngularVelocity(t).squaredNorm());
      places.push_back({d, t});
    }
  }
  const auto half = std::lower_bound(turned.begin() + 1, turned.end() - 1, share * turned.back());
  const Place cut = places[static_cast<std::size_t>(half - turned.begin()) - 1];
  Halves halves;
  for (std::size_t d = 0; d < state.drives.size(); ++d) {
    const SplitSpline& trajectory = state.drives[d].trajectory;
    const double at = d < cut.drive ? trajectory.End() : d > cut.drive ? trajectory.Start() : cut.time;
    halves.first.push_back({trajectory.Start(), at});
    halves.second.push_back({at, trajectory.End()});
  }
  return halves;
}

std::vector<SensorHalves> CompareHalves(const Adjustment& adjustment, const Dataset& dataset,
                                        const CancellationToken& cancellation) {
  const CalibrationState& state = adjustment.state;
  const Layout layout(state, adjustment.problem.estimate_imu_matrices);
  const double scale = VarianceScale(adjustment, dataset);
  const Halves halves = CutByTurning(state, 0.5);
  const auto calibrate = [&](const std::vector<TimeInterval>& part) {
    return CalibrateHalf(adjustment, scale, part, cancellation);
  };
  const std::optional<HalfCalibration> first = calibrate(halves.first);
  if (!first) return {};
  const std::optional<HalfCalibration> second = calibrate(halves.second);
  if (!second) return {};
  const Eigen::VectorXd limits = CalibrationLimits(state, layout);
  const double of_whole = InformationOf(*first, limits) + InformationOf(*second, limits);
  std::vector<SensorHalves> sensors(layout.order.size());
  const auto compare = [&](DriveParts parts, const std::optional<HalfCalibration>& earlier,
                           const std::optional<HalfCalibration>& later) {
    if (!earlier || !later) return;
    const Compared compared = Compare(adjustment, *earlier, *later, of_whole, scale);
    for (std::size_t s = 0; s < sensors.size(); ++s) {
      SensorHalves sensor = CompareSensor(adjustment, layout, compared, layout.order.At(s));
      sensor.parts = parts;
      if (parts == DriveParts::kHalves || WorstOf(sensor) > WorstOf(sensors[s])) sensors[s] = sensor;
    }
  };
  compare(DriveParts::kHalves, first, second);
  compare(DriveParts::kBeginning, calibrate(CutByTurning(state, 0.25).first), second);
  compare(DriveParts::kEnd, first, calibrate(CutByTurning(state, 0.75).second));
  return sensors;
}

std::string Describe(const SensorHalves& sensor) {
  std::string line;
  for (const HalvesDifference& quantity : sensor.quantities) {
    double squares = 0.0;
    for (const double d : quantity.difference) squares += d * d;
    const double size = std::sqrt(squares);
    char text[120];
    const double worst = quantity.Worst();
    switch (quantity.quantity) {
      case Quantity::kRotation:
        std::snprintf(text, sizeof(text), "rotation by %.4f deg (%.1f sigma)", size * 180.0 / M_PI, worst);
        break;
      case Quantity::kTranslation:
        std::snprintf(text, sizeof(text), "translation by %.2f mm (%.1f)", 1e3 * size, worst);
        break;
      case Quantity::kTimeOffset:
        std::snprintf(text, sizeof(text), "time offset by %.3f ms (%.1f)", 1e3 * size, worst);
        break;
      case Quantity::kIntrinsics:
        std::snprintf(text, sizeof(text), "intrinsics (%.1f)", worst);
        break;
    }
    line += (line.empty() ? "" : ", ") + std::string(text);
  }
  return line;
}

}  // namespace mlic
