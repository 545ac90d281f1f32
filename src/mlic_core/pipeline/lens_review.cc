#include "mlic_core/pipeline/lens_review.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <utility>
#include <vector>

#include "mlic_core/sensors/double_sphere_twin.h"

namespace mlic {
namespace {

std::optional<CameraIntrinsics> TwinOf(const Adjustment& adjustment, std::size_t camera) {
  const CameraIntrinsics& intrinsics = adjustment.state.cameras[camera].intrinsics;
  if (intrinsics.model != CameraModel::kDoubleSphere || !adjustment.cameras.found[camera])
    return std::nullopt;
  const std::vector<bool>& fixed = adjustment.problem.cameras[camera].fixed.intrinsics;
  if (std::find(fixed.begin(), fixed.end(), true) != fixed.end()) return std::nullopt;
  return DoubleSphereTwin(intrinsics);
}

// What a solve changes; planes are as they are associated.
struct Solved {
  CalibrationState state;
  SolveSummary summary;
  std::vector<LandmarkSet> landmarks;  // of each drive
};

Solved Keep(const Adjustment& adjustment) {
  Solved kept{adjustment.state, adjustment.last_solve, {}};
  for (const DriveTerms& drive : adjustment.problem.drives) kept.landmarks.push_back(drive.landmarks);
  return kept;
}

void GoBack(Solved kept, Adjustment* adjustment) {
  adjustment->state = std::move(kept.state);
  adjustment->last_solve = std::move(kept.summary);
  for (std::size_t d = 0; d < kept.landmarks.size(); ++d) {
    adjustment->problem.drives[d].landmarks = std::move(kept.landmarks[d]);
  }
}

// Standard deviation of intrinsics of which two values are left, the second one less likely by exp(-gain /
// 2).
std::vector<double> Spread(const CameraIntrinsics& a, const CameraIntrinsics& b, double gain) {
  const double second = 1.0 / (1.0 + std::exp(0.5 * gain));
  std::vector<double> spread;
  for (std::size_t i = 0; i < a.parameters.size(); ++i) {
    spread.push_back(std::sqrt(second * (1.0 - second)) * std::abs(a.parameters[i] - b.parameters[i]));
  }
  return spread;
}

}  // namespace

bool ReviewLenses(const AdjustmentContext& context, bool probe_matrices, Adjustment* adjustment) {
  bool changed = false;
  std::vector<std::vector<double>>& twins = adjustment->cameras.twins;
  twins.assign(adjustment->state.cameras.size(), {});
  for (std::size_t c = 0; c < adjustment->state.cameras.size(); ++c) {
    const std::optional<CameraIntrinsics> twin = TwinOf(*adjustment, c);
    if (!twin) continue;
    // The noise has been measured anew since the last solve: both are solved with it.
    adjustment->last_solve = SolveAdjustment(context.monitor.cancellation, adjustment, probe_matrices);
    Solved before = Keep(*adjustment);
    adjustment->state.cameras[c].intrinsics = *twin;
    adjustment->last_solve = SolveAdjustment(context.monitor.cancellation, adjustment, probe_matrices);
    const double gain = before.summary.last_cost - adjustment->last_solve.last_cost;
    const double xi[] = {before.state.cameras[c].intrinsics.parameters[4],
                         adjustment->state.cameras[c].intrinsics.parameters[4]};
    char text[160];
    std::snprintf(text, sizeof(text), ": xi is %.3f, not %.3f, which projects alike but costs %.0f more",
                  xi[gain > 0.0 ? 1 : 0], xi[gain > 0.0 ? 0 : 1], std::abs(gain));
    context.monitor.line(context.rig.cameras[c].name + text);
    twins[c] =
        Spread(before.state.cameras[c].intrinsics, adjustment->state.cameras[c].intrinsics, std::abs(gain));
    if (gain > 0.0) {
      changed = true;
    } else {
      GoBack(std::move(before), adjustment);
    }
  }
  return changed;
}

}  // namespace mlic
