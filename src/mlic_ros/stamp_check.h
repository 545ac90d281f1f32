#pragma once

#include <string>
#include <vector>

#include "mlic_core/common/time.h"

namespace mlic {

// When a message says it was measured, and when it was recorded.
struct MessageTimes {
  TimeNs stamp = 0;
  TimeNs record = 0;
};

// What is odd about the stamps of one topic.
struct StampReport {
  double period = 0.0;                // median, s
  std::size_t duplicates = 0;         // same stamp as an earlier message
  std::size_t out_of_order = 0;       // stamped before an earlier message
  std::size_t missing = 0;            // messages lacking in gaps of more than 1.5 periods
  double longest_gap = 0.0;           // s
  std::vector<std::string> warnings;  // changes of period, clock jumps; each one line without the topic
};

// messages: in order of recording. Times in the warnings are seconds after the first stamp.
StampReport CheckStamps(const std::vector<MessageTimes>& messages);

}  // namespace mlic
