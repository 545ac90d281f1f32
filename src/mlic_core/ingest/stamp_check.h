#pragma once

#include <string>
#include <vector>

#include "mlic_core/common/time.h"
#include "mlic_core/ingest/clock_fit.h"

namespace mlic {

// What is odd about the stamps of one topic.
struct StampReport {
  double period = 0.0;           // median, s
  std::size_t duplicates = 0;    // same stamp as an earlier message
  std::size_t out_of_order = 0;  // stamped before an earlier message
  std::size_t missing = 0;       // messages lacking in gaps of more than 1.5 periods
  double longest_gap = 0.0;      // s
  // The messages of the longest part without a clock jump, [first, last).
  std::size_t steady_begin = 0, steady_end = 0;
  std::vector<std::string> warnings;  // changes of period, clock jumps; each one line without the topic
};

// messages: in order of recording. Times in the warnings are seconds after the first stamp. Where the
// clock jumped (FitClock) the messages fall into parts; the counts are those of the longest.
StampReport CheckStamps(const std::vector<MessageTimes>& messages);

// CheckStamps of items in order of recording, of which only the longest part without a clock jump is kept:
// one time offset serves no other. times_of(item): its MessageTimes.
template <typename Item, typename TimesOf>
StampReport KeepSteadyPart(std::vector<Item>& items, const TimesOf& times_of) {
  std::vector<MessageTimes> times;
  for (const Item& item : items) times.push_back(times_of(item));
  StampReport report = CheckStamps(times);
  items.erase(items.begin() + static_cast<std::ptrdiff_t>(report.steady_end), items.end());
  items.erase(items.begin(), items.begin() + static_cast<std::ptrdiff_t>(report.steady_begin));
  return report;
}

}  // namespace mlic
