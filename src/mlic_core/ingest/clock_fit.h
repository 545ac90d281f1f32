#pragma once

#include <vector>

#include "mlic_core/common/time.h"

namespace mlic {

// When a message says it was measured, and when it was recorded.
struct MessageTimes {
  TimeNs stamp = 0;
  TimeNs record = 0;
};

// A message's delay is its recording time less its stamp. Computers and networks only ever add to it, so that
// the least delay over some seconds follows the difference of the two clocks, and all single delays do not.

// From one message to the next the clock of the stamps steps against the recorder's, and stays there.
struct ClockJump {
  std::size_t index = 0;  // of the first message after it
  double step = 0.0;      // s, of the stamps against the recorder's clock
};

struct ClockFit {
  std::vector<ClockJump> jumps;
  // Rate of the stamps' clock against the recorder's, without the jumps: 1e-6 is a microsecond a second.
  double drift_ppm = 0.0;
  double drift_sigma_ppm = 0.0;  // from the scatter of the least delays; infinite where there are too few
  double wander = 0.0;           // s, what the least delays of neighbouring windows usually differ by
  // The stamps were taken on arrival: they are as irregular as the recording times, and agree with them.
  bool stamped_on_arrival = false;
};

// messages: of one topic in order of recording, at least two.
ClockFit FitClock(const std::vector<MessageTimes>& messages);

}  // namespace mlic
