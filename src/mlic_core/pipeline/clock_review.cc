#include "mlic_core/pipeline/clock_review.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mlic_core/geometry/symmetric_matrix.h"
#include "mlic_core/problem/noise_information.h"
#include "mlic_core/solver/submatrix.h"
#include "mlic_core/uncertainty/observability.h"

namespace mlic {
namespace {

constexpr double kShown = 3.0;  // sigmas; from: derivation, 0.3 % of normal errors lie beyond

SensorCalibration& Calibration(SensorId sensor, CalibrationState* state) {
  return sensor.IsLidar() ? state->lidars[sensor.index] : state->cameras[sensor.index].sensor;
}

// Whether some of these clocks drifts beside the others and the IMU's, all of which keep step. What sensors
// drift against each other can be known far better than what all of them drift against the IMU.
// covariance: of all parameters (Layout).
bool AnyDrifts(const std::vector<SensorId>& clocks, const Layout& layout, const Eigen::MatrixXd& covariance,
               const Eigen::VectorXd& drifts) {
  std::vector<int> places;
  for (const SensorId id : clocks) places.push_back(layout.Drift(id));
  const Eigen::MatrixXd of_drifts = Submatrix(covariance, places);
  const Eigen::MatrixXd information =
      SolveSymmetric(of_drifts, Eigen::MatrixXd::Identity(of_drifts.rows(), of_drifts.rows()));
  const Eigen::ArrayXd pull = (information * drifts).array();
  return (pull.square() > kShown * kShown * information.diagonal().array()).any();
}

// Of the clocks that the last solve probed.
bool MayDrift(const AdjustmentContext& context, const Adjustment& adjustment) {
  const DriftProbe& probe = adjustment.last_solve.drifts;
  if (probe.clocks.empty()) return false;
  CalibrationState state = adjustment.state;
  for (const SensorId id : probe.clocks) Calibration(id, &state).clock_drift = 0.0;
  const Layout layout(state, adjustment.problem.estimate_imu_matrices);
  const ObservabilityAnalysis analysis = AnalyzeCalibration(
      adjustment.problem, state, probe.information / VarianceScale(adjustment, context.dataset));
  std::vector<int> places;
  for (const SensorId id : probe.clocks) places.push_back(layout.Drift(id));
  return AnyDrifts(probe.clocks, layout, analysis.whole_covariance, SelectRows(probe.step, places));
}

void Report(const AdjustmentContext& context, const ObservabilityAnalysis& analysis, SensorId sensor,
            const Adjustment& adjustment) {
  const std::optional<double>& drift = adjustment.state.Sensor(sensor).clock_drift;
  char text[120];
  std::snprintf(text, sizeof(text), ": its clock drifts by %.2f ppm (sigma %.2f)", 1e6 * drift.value_or(0.0),
                1e6 * analysis.sensors[adjustment.state.Sensors().PlaceOf(sensor)].drift_sigma);
  context.monitor.line(NameOf(sensor, context.rig) + (drift ? text : ": its clock does not drift"));
}

}  // namespace

std::vector<SensorId> ConstantClocks(const Adjustment& adjustment) {
  std::vector<SensorId> constant;
  const SensorOrder order = adjustment.state.Sensors();
  for (std::size_t s = 0; s < order.size(); ++s) {
    const SensorId id = order.At(s);
    const bool held = id.IsLidar() ? adjustment.problem.lidars[id.index].fixed
                                   : adjustment.problem.cameras[id.index].fixed.time_offset;
    const bool judged = s < adjustment.constant_clocks.size() && adjustment.constant_clocks[s];
    if (!held && !judged && !adjustment.state.Sensor(id).clock_drift) constant.push_back(id);
  }
  return constant;
}

bool ReviewClocks(const AdjustmentContext& context, Adjustment* adjustment) {
  const SensorOrder order = adjustment->state.Sensors();
  adjustment->constant_clocks.resize(order.size(), false);
  const std::vector<SensorId> freed =
      MayDrift(context, *adjustment) ? adjustment->last_solve.drifts.clocks : std::vector<SensorId>{};
  std::vector<SensorId> drifting = freed;
  for (std::size_t s = 0; s < order.size(); ++s) {
    if (adjustment->state.Sensor(order.At(s)).clock_drift) drifting.push_back(order.At(s));
  }
  if (drifting.empty()) return false;
  Adjustment trial = *adjustment;
  if (!freed.empty()) {
    for (const SensorId id : freed) Calibration(id, &trial.state).clock_drift = 0.0;
    trial.last_solve = SolveAdjustment(context.monitor.cancellation, &trial);
  }
  const LinearizedProblem linearized(trial.problem, trial.state);
  if (!freed.empty()) {
    trial.noise_information = NoiseInformation(linearized, context.monitor.cancellation);
  }
  MeasureScale(linearized, trial, &trial.scale);
  const ObservabilityAnalysis analysis = Analyze(trial, context.dataset);
  Eigen::VectorXd drifts(static_cast<Eigen::Index>(drifting.size()));
  for (std::size_t i = 0; i < drifting.size(); ++i) {
    drifts[static_cast<Eigen::Index>(i)] = *trial.state.Sensor(drifting[i]).clock_drift;
  }
  const Layout layout(trial.state, trial.problem.estimate_imu_matrices);
  const bool shown = AnyDrifts(drifting, layout, analysis.whole_covariance, drifts);
  if (!shown) {
    for (const SensorId id : drifting) {
      adjustment->constant_clocks[order.PlaceOf(id)] = true;
      Calibration(id, &trial.state).clock_drift.reset();
    }
  }
  const bool changed = shown ? !freed.empty() : freed.size() < drifting.size();
  if (!changed) return false;
  trial.constant_clocks = adjustment->constant_clocks;
  trial.scale = adjustment->scale;
  *adjustment = std::move(trial);
  if (!shown) adjustment->last_solve = SolveAdjustment(context.monitor.cancellation, adjustment);
  for (const SensorId id : drifting) Report(context, analysis, id, *adjustment);
  return true;
}

}  // namespace mlic
