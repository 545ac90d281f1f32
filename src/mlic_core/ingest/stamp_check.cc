#include "mlic_core/ingest/stamp_check.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "mlic_core/lidar/point_time.h"

namespace mlic {
namespace {

// from: guard, their median scatters by far less than kPeriodTolerance.
constexpr std::size_t kPeriodWindow = 20;  // differences over which a period is measured
// from: guard, medians scatter by far less, settings of drivers differ by far more.
constexpr double kPeriodTolerance = 0.1;  // share by which it may differ from the whole recording's

std::string Format(const char* format, double a, double b, double c = 0.0) {
  char text[200];
  std::snprintf(text, sizeof(text), format, a, b, c);
  return text;
}

// The first place where the period stays different for a whole window.
void FindPeriodChange(const std::vector<TimeNs>& sorted, StampReport& report) {
  for (std::size_t i = 0; i + kPeriodWindow < sorted.size(); i += kPeriodWindow / 2) {
    const std::vector<TimeNs> window(sorted.begin() + i, sorted.begin() + i + kPeriodWindow + 1);
    const double period = MedianPeriod(window);
    if (std::abs(period - report.period) <= kPeriodTolerance * report.period) continue;
    report.warnings.push_back(Format("the period changes: %.4g s at %.2f s after the start, %.4g s otherwise",
                                     period, SecondsSince(sorted.front(), window.front()), report.period));
    return;
  }
}

// Says of the largest jump and finds the longest part between any two.
void CutAtJumps(const std::vector<MessageTimes>& messages, StampReport& report) {
  report.steady_end = messages.size();
  const std::vector<ClockJump> jumps = FitClock(messages).jumps;
  if (jumps.empty()) return;
  std::vector<std::size_t> ends;
  const ClockJump* largest = &jumps.front();
  for (const ClockJump& jump : jumps) {
    ends.push_back(jump.index);
    if (std::abs(jump.step) > std::abs(largest->step)) largest = &jump;
  }
  ends.push_back(messages.size());
  double longest = -1.0;
  std::size_t begin = 0;
  for (const std::size_t end : ends) {
    const double length = SecondsSince(messages[begin].record, messages[end - 1].record);
    if (length > longest) {
      longest = length;
      report.steady_begin = begin;
      report.steady_end = end;
    }
    begin = end;
  }
  report.warnings.push_back(
      std::to_string(jumps.size()) + " clock jump(s), the largest by " +
      Format("%+.4g s %.2f s after the start", largest->step,
             SecondsSince(messages.front().record, messages[largest->index].record)) +
      Format(
          "; only the longest part between jumps is used, %.1f of %.1f s, and the time offset is that part's",
          longest, SecondsSince(messages.front().record, messages.back().record)));
}

}  // namespace

StampReport CheckStamps(const std::vector<MessageTimes>& messages) {
  StampReport report;
  std::vector<TimeNs> all;
  for (const MessageTimes& message : messages) all.push_back(message.stamp);
  CutAtJumps(messages, report);
  std::vector<TimeNs> stamps(all.begin() + static_cast<std::ptrdiff_t>(report.steady_begin),
                             all.begin() + static_cast<std::ptrdiff_t>(report.steady_end));
  TimeNs latest = stamps.empty() ? 0 : stamps.front();
  for (const TimeNs stamp : stamps) {
    if (stamp < latest) ++report.out_of_order;
    latest = std::max(latest, stamp);
  }
  std::sort(stamps.begin(), stamps.end());
  const auto last = std::unique(stamps.begin(), stamps.end());
  report.duplicates = static_cast<std::size_t>(stamps.end() - last);
  stamps.erase(last, stamps.end());
  report.period = MedianPeriod(stamps);
  for (std::size_t i = 1; i < stamps.size(); ++i) {
    const double gap = SecondsSince(stamps[i - 1], stamps[i]);
    report.longest_gap = std::max(report.longest_gap, gap);
    if (gap > 1.5 * report.period)
      report.missing += static_cast<std::size_t>(std::llround(gap / report.period)) - 1;
  }
  FindPeriodChange(stamps, report);
  return report;
}

}  // namespace mlic
