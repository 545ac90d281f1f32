#pragma once

#include <vector>

#include "mlic_core/common/time_interval.h"
#include "mlic_core/problem/joint_problem.h"
#include "mlic_core/problem/state.h"

namespace mlic {

// One drive's stretch of a problem. Clocks' offsets belong to the middle of the trajectory, which is another
// one in the part: where a clock drifts, its times are shifted so that the offset stays the same number.
// Times: s.
struct DriveStretch {
  TimeInterval interval;  // IMU clock
  double whole_middle;    // of the whole drive's trajectory, IMU clock
  double middle;          // of the part's

  // What the sensor measured at a time of its own clock belongs to the stretch.
  bool Contains(const SensorCalibration& sensor, double time) const {
    return interval.Contains(sensor.OnImuClock(time, whole_middle));
  }
  // The sensor's time in the part.
  double Shifted(const SensorCalibration& sensor, double time) const;
};

// A joint problem with the observations of one stretch of each drive alone, about the same state: splines are
// cut to their stretch, so that it costs no more than its share. The calibration has the Layout of the whole,
// with biases of its own for each drive; a drive without a stretch (start == end) takes no part. Landmarks
// are those of the whole, as far as the stretch alone determines them. Priors and what is fixed stay as they
// are.
struct PartialProblem {
  // intervals: of each drive, within its trajectory, on the IMU's clock.
  PartialProblem(const JointProblem& whole, const CalibrationState& whole_state,
                 const std::vector<TimeInterval>& intervals);
  PartialProblem(const PartialProblem&) = delete;
  PartialProblem& operator=(const PartialProblem&) = delete;

  Dataset dataset;  // the IMU's samples alone
  CalibrationState state;
  JointProblem problem;  // of that dataset
  std::vector<DriveStretch> stretches;
};

}  // namespace mlic
