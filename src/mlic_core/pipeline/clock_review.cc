#include "mlic_core/pipeline/clock_review.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mlic_core/problem/noise_information.h"
#include "mlic_core/uncertainty/observability.h"

namespace mlic {
namespace {

constexpr double kShown = 3.0;  // sigmas; from: derivation, 0.3 % of normal errors lie beyond

SensorCalibration& Calibration(SensorId sensor, CalibrationState* state) {
  return sensor.IsLidar() ? state->lidars[sensor.index] : state->cameras[sensor.index].sensor;
}

bool IsShown(const Adjustment& adjustment, const ObservabilityAnalysis& analysis, SensorId sensor) {
  const double sigma = analysis.sensors[adjustment.state.Sensors().PlaceOf(sensor)].drift_sigma;
  return std::abs(*adjustment.state.Sensor(sensor).clock_drift) > kShown * sigma;
}

// Of the clocks that the last solve probed, those whose drift may be shown.
std::vector<SensorId> MayDrift(const AdjustmentContext& context, const Adjustment& adjustment) {
  const DriftProbe& probe = adjustment.last_solve.drifts;
  if (probe.clocks.empty()) return {};
  CalibrationState state = adjustment.state;
  for (const SensorId id : probe.clocks) Calibration(id, &state).clock_drift = 0.0;
  const Layout layout(state, adjustment.problem.estimate_imu_matrices);
  const ObservabilityAnalysis analysis = AnalyzeCalibration(
      adjustment.problem, state, probe.information / VarianceScale(adjustment, context.dataset));
  std::vector<SensorId> drifting;
  for (const SensorId id : probe.clocks) {
    const double sigma = analysis.sensors[state.Sensors().PlaceOf(id)].drift_sigma;
    if (std::abs(probe.step[layout.Drift(id)]) > kShown * sigma) drifting.push_back(id);
  }
  return drifting;
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
  const std::vector<SensorId> freed = MayDrift(context, *adjustment);
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
  bool changed = false, taken_back = false;
  for (const SensorId id : drifting) {
    const bool is_new = !adjustment->state.Sensor(id).clock_drift;
    if (IsShown(trial, analysis, id)) {
      changed |= is_new;
      continue;
    }
    changed |= !is_new;
    taken_back = adjustment->constant_clocks[order.PlaceOf(id)] = true;
    Calibration(id, &trial.state).clock_drift.reset();
  }
  if (!changed) return false;
  trial.constant_clocks = adjustment->constant_clocks;
  trial.scale = adjustment->scale;
  *adjustment = std::move(trial);
  if (taken_back) adjustment->last_solve = SolveAdjustment(context.monitor.cancellation, adjustment);
  for (const SensorId id : drifting) Report(context, analysis, id, *adjustment);
  return true;
}

}  // namespace mlic
