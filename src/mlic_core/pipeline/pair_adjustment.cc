#include "mlic_core/pipeline/pair_adjustment.h"

#include "mlic_core/pipeline/joint_adjustment.h"

namespace mlic {

Adjustment StartPairAdjustment(const LidarsAlone& alone) {
  // Where nothing moves, what scans seem to say of their times is noise.
  constexpr double kHeldOffset = 1e-5;  // s; from: guard, far below what moves a pose
  Adjustment adjustment = StartAdjustment(alone.rig, alone.dataset, alone.start);
  for (std::size_t l = 0; l < alone.tied.size(); ++l) {
    LidarTerms& terms = adjustment.problem.lidars[l];
    adjustment.rejected_lidars[l] = !alone.tied[l];
    terms.fixed = terms.fixed || !alone.tied[l];
    terms.given_time_offset = alone.start.state.lidars[l].time_offset;
    terms.time_offset_sigma = alone.parked ? kHeldOffset : alone.time_offset_sigmas[l];
  }
  return adjustment;
}

Adjustment AdjustPairs(Adjustment adjustment, const AdjustmentContext& context,
                       const std::function<void(const Adjustment&)>& after_round) {
  JointOptions options;
  options.find_sensor_errors = false;
  options.after_round = after_round;
  adjustment = AdjustJointly(std::move(adjustment), context, options);
  MeasureUncertainty(context, &adjustment);
  return adjustment;
}

}  // namespace mlic
