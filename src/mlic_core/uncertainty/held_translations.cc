#include "mlic_core/uncertainty/held_translations.h"

#include <algorithm>
#include <cmath>

#include "mlic_core/geometry/symmetric_matrix.h"
#include "mlic_core/problem/layout.h"
#include "mlic_core/sensors/observability_limits.h"

namespace mlic {
namespace {

// A sensor with a guess and a direction of translation that the data do not show.
struct OpenSensor {
  int at = 0;  // of its translation, in the calibration
  Eigen::Vector3d guess_sigma;
};

std::vector<OpenSensor> OpenSensors(const JointProblem& problem, const SensorOrder& order,
                                    const ObservabilityAnalysis& analysis) {
  std::vector<OpenSensor> open;
  for (std::size_t s = 0; s < order.size(); ++s) {
    const std::optional<ExtrinsicGuess>& guess = GuessOf(order.At(s), problem);
    const auto& directions = analysis.sensors[s].directions;
    const bool shown = std::none_of(directions.begin(), directions.end(), [](const UnobservableDirection& d) {
      return d.quantity == UnobservableDirection::Quantity::kTranslation;
    });
    if (guess && !shown) open.push_back({Layout::Sensor(s) + 3, guess->sigma_translation});
  }
  return open;
}

// Whether the covariance of one sensor's translation shows all directions to their limits.
bool ShowsAll(const Eigen::Matrix3d& covariance, const Eigen::Vector3d& guess_sigma) {
  const SymmetricEigen<3> eigen(covariance);
  for (int i = 0; i < 3; ++i) {
    const double limit =
        std::min(kTranslationLimit, eigen.eigenvectors().col(i).cwiseProduct(guess_sigma).norm());
    if (eigen.eigenvalues()[i] > limit * limit) return false;
  }
  return true;
}

}  // namespace

std::vector<Eigen::VectorXd> UnobservableTranslations(const JointProblem& problem, const SensorOrder& order,
                                                      const ObservabilityAnalysis& analysis) {
  const std::vector<OpenSensor> open = OpenSensors(problem, order, analysis);
  const auto count = static_cast<Eigen::Index>(open.size());
  Eigen::MatrixXd remaining(3 * count, 3 * count);
  for (Eigen::Index a = 0; a < count; ++a) {
    for (Eigen::Index b = 0; b < count; ++b) {
      remaining.block<3, 3>(3 * a, 3 * b) = analysis.data_covariance.block<3, 3>(open[a].at, open[b].at);
    }
  }
  std::vector<Eigen::VectorXd> held;
  if (count == 0) return held;
  const SymmetricEigen<Eigen::Dynamic> eigen(remaining);
  for (Eigen::Index i = 3 * count - 1; i >= 0; --i) {
    bool all = true;
    for (Eigen::Index s = 0; s < count; ++s) {
      all = all && ShowsAll(remaining.block<3, 3>(3 * s, 3 * s), open[s].guess_sigma);
    }
    if (all) break;
    const Eigen::VectorXd direction = eigen.eigenvectors().col(i);
    remaining -= eigen.eigenvalues()[i] * direction * direction.transpose();
    Eigen::VectorXd row = Eigen::VectorXd::Zero(analysis.data_covariance.rows());
    for (Eigen::Index s = 0; s < count; ++s) {
      const Eigen::Vector3d part = direction.segment<3>(3 * s);
      const double variance = part.cwiseProduct(open[s].guess_sigma).squaredNorm();
      if (variance > 0.0) row.segment<3>(open[s].at) = part * (part.squaredNorm() / variance);
    }
    held.push_back(row.normalized());
  }
  return held;
}

}  // namespace mlic
