#pragma once

#include <vector>

#include "mlic_core/common/time_interval.h"
#include "mlic_core/problem/joint_problem.h"
#include "mlic_core/problem/state.h"

namespace mlic {

// A joint problem with the observations of one stretch of each drive alone, about the same state: splines are
// cut to their stretch, so that it costs no more than its share. The calibration has the Layout of the whole,
// with biases of its own for each drive; a drive without a stretch (start == end) takes no part. Landmarks
// are those of the whole, as far as the stretch alone determines them. Priors and what is fixed stay as they
// are.
struct PartialProblem {
  // stretches: of each drive, within its trajectory, on the IMU's clock.
  PartialProblem(const JointProblem& whole, const CalibrationState& whole_state,
                 const std::vector<TimeInterval>& stretches);
  PartialProblem(const PartialProblem&) = delete;
  PartialProblem& operator=(const PartialProblem&) = delete;

  Dataset dataset;  // the IMU's samples alone
  CalibrationState state;
  JointProblem problem;  // of that dataset
};

}  // namespace mlic
