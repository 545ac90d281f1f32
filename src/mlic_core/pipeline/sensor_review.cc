#include "mlic_core/pipeline/sensor_review.h"

#include "mlic_core/association/group_errors.h"
#include "mlic_core/association/ring_corrections.h"
#include "mlic_core/pipeline/imu_review.h"
#include "mlic_core/pipeline/lens_review.h"
#include "mlic_core/pipeline/stamp_review.h"
#include "mlic_core/uncertainty/range_corrections.h"

namespace mlic {
namespace {

// Once the stamps of cameras have moved, so many rounds find landmarks and matches anew. from: measured,
// paper rig, seeds 1 to 3; what agrees, then its noise
constexpr int kLandmarkRoundsAfterStamps = 2;

// What LiDARs err by: their rings, and all their ranges together, which is asked once in the rounds with
// rings that stand still, and again where ranges err: what rings err by hides how ranges go with the
// brightness. True if any correction has moved.
bool ReviewRanges(Adjustment* adjustment) {
  const double correlation = CorrelationFactor(adjustment->problem.drives, adjustment->state);
  const bool rings_moved = CorrectRings(adjustment->problem.drives, correlation, &adjustment->state);
  if (adjustment->rounds.ranges_measured && !AnyRangeCorrected(adjustment->state)) return rings_moved;
  adjustment->rounds.ranges_measured = !rings_moved;
  return CorrectRanges(adjustment->problem, correlation, &adjustment->rounds.walks_dropped,
                       &adjustment->state) ||
         rings_moved;
}

// From now on clocks may drift against the IMU's. True if there are any that could not before.
bool FreeClocks(const AdjustmentContext& context, bool probe_matrices, Adjustment* adjustment) {
  bool any = false;
  const SensorOrder order = adjustment->state.Sensors();
  for (std::size_t s = 0; s < order.size(); ++s) {
    const SensorId id = order.At(s);
    SensorCalibration& sensor =
        id.IsLidar() ? adjustment->state.lidars[id.index] : adjustment->state.cameras[id.index].sensor;
    const bool held = id.IsLidar() ? adjustment->problem.lidars[id.index].fixed
                                   : adjustment->problem.cameras[id.index].fixed.time_offset;
    if (held || sensor.clock_drift) continue;
    any = true;
    sensor.clock_drift = 0.0;
  }
  if (!any) return false;
  adjustment->rounds.noise_measured = false;
  adjustment->last_solve = SolveAdjustment(context.monitor.cancellation, adjustment, probe_matrices);
  return true;
}

}  // namespace

SensorError FindSensorError(const AdjustmentContext& context, bool probe_matrices, Adjustment* adjustment) {
  JointRounds& rounds = adjustment->rounds;
  const bool cameras = rounds.landmarks != Landmarks::kNone;
  bool lens = false;
  if (!rounds.clocks_freed) {
    rounds.clocks_freed = true;
    lens = cameras && ReviewLenses(context, probe_matrices, adjustment);
    if (FreeClocks(context, probe_matrices, adjustment)) return SensorError::kClock;
  }
  if (cameras && !rounds.stamps_settled && ReviewStamps(context, probe_matrices, adjustment)) {
    rounds.landmark_rounds = rounds.done + 1 + kLandmarkRoundsAfterStamps;
    return SensorError::kStamps;
  }
  // What stood for scale, axes or a bias that wanders is not the stamps'.
  if (ReviewMatrices(context, adjustment)) {
    rounds.stamps_settled = false;
    return SensorError::kImuMatrices;
  }
  if (ReviewBiases(context, adjustment)) {
    rounds.stamps_settled = false;
    return SensorError::kBiases;
  }
  if (ReviewRanges(adjustment)) {
    rounds.matrices_judged = false;  // a LiDAR may show what it did not before
    return SensorError::kRanges;
  }
  return lens ? SensorError::kLens : SensorError::kNone;
}

}  // namespace mlic
