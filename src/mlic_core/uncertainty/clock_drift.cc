#include "mlic_core/uncertainty/clock_drift.h"

#include <vector>

#include "mlic_core/geometry/symmetric_matrix.h"
#include "mlic_core/problem/layout.h"
#include "mlic_core/solver/submatrix.h"

namespace mlic {

bool ClocksDrift(const CalibrationState& state, bool estimate_imu_matrices,
                 const ObservabilityAnalysis& analysis) {
  constexpr double kShown = 3.0;  // sigmas; from: derivation, 0.3 % of normal errors lie beyond
  const Layout layout(state, estimate_imu_matrices);
  std::vector<int> places;
  std::vector<double> drifts;
  for (std::size_t s = 0; s < layout.drift.size(); ++s) {
    if (layout.drift[s] < 0) continue;
    places.push_back(layout.drift[s]);
    drifts.push_back(*state.Sensor(layout.order.At(s)).clock_drift);
  }
  if (places.empty()) return false;
  const auto count = static_cast<Eigen::Index>(places.size());
  const Eigen::MatrixXd information =
      SolveSymmetric(Submatrix(analysis.whole_covariance, places), Eigen::MatrixXd::Identity(count, count));
  const Eigen::ArrayXd pull = (information * Eigen::Map<const Eigen::VectorXd>(drifts.data(), count)).array();
  return (pull.square() > kShown * kShown * information.diagonal().array()).any();
}

}  // namespace mlic
