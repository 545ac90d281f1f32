#include "mlic_core/ingest/stamp_check.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>

#include "mlic_core/lidar/point_time.h"

namespace mlic {
namespace {

// from: guard, their median scatters by far less than kPeriodTolerance.
constexpr std::size_t kWindow = 20;  // differences over which a period is measured
// from: guard, medians scatter by far less, settings of drivers differ by far more.
constexpr double kPeriodTolerance = 0.1;  // share by which it may differ from the whole recording's
constexpr double kSmallestJump = 0.25;    // s; recording itself delays messages by less; from: guard
constexpr double kSteady = 2.0;           // s; bursts of late messages are shorter; from: guard

std::string Format(const char* format, double a, double b, double c = 0.0) {
  char text[200];
  std::snprintf(text, sizeof(text), format, a, b, c);
  return text;
}

// The first place where the period stays different for a whole window.
void FindPeriodChange(const std::vector<TimeNs>& sorted, StampReport& report) {
  for (std::size_t i = 0; i + kWindow < sorted.size(); i += kWindow / 2) {
    const std::vector<TimeNs> window(sorted.begin() + i, sorted.begin() + i + kWindow + 1);
    const double period = MedianPeriod(window);
    if (std::abs(period - report.period) <= kPeriodTolerance * report.period) continue;
    report.warnings.push_back(Format("the period changes: %.4g s at %.2f s after the start, %.4g s otherwise",
                                     period, SecondsSince(sorted.front(), window.front()), report.period));
    return;
  }
}

// The least delay from stamp to recording over the messages [begin, end), s.
double LeastDelay(const std::vector<MessageTimes>& messages, std::size_t begin, std::size_t end) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = begin; i < end; ++i) {
    least = std::min(least, SecondsSince(messages[i].stamp, messages[i].record));
  }
  return least;
}

// From message at - 1 to message `at`, and for seconds before and after it.
bool IsClockJump(const std::vector<MessageTimes>& messages, std::size_t at, double period) {
  const double limit = std::max(kSmallestJump, 2.5 * period);
  const double step = SecondsSince(messages[at - 1].stamp, messages[at].stamp) -
                      SecondsSince(messages[at - 1].record, messages[at].record);
  if (std::abs(step) <= limit) return false;
  std::size_t begin = at - 1, end = at + 1;
  while (begin > 0 && SecondsSince(messages[begin - 1].record, messages[at - 1].record) < kSteady) --begin;
  while (end < messages.size() && SecondsSince(messages[at].record, messages[end].record) < kSteady) ++end;
  return std::abs(LeastDelay(messages, at, end) - LeastDelay(messages, begin, at)) > limit;
}

// Says of the first jump and finds the longest part between any two.
void FindClockJumps(const std::vector<MessageTimes>& messages, double period, StampReport& report) {
  std::size_t jumps = 0, begin = 0;
  TimeNs longest = -1;
  std::string first;
  const auto end_part = [&](std::size_t end) {
    const TimeNs length = messages[end - 1].record - messages[begin].record;
    if (length > longest) {
      longest = length;
      report.steady_begin = begin;
      report.steady_end = end;
    }
    begin = end;
  };
  for (std::size_t i = 1; i < messages.size(); ++i) {
    if (!IsClockJump(messages, i, period)) continue;
    end_part(i);
    if (jumps++ > 0) continue;
    first = Format("stamps advance by %.3f s while recording advances by %.3f s, %.2f s after the start",
                   SecondsSince(messages[i - 1].stamp, messages[i].stamp),
                   SecondsSince(messages[i - 1].record, messages[i].record),
                   SecondsSince(messages.front().record, messages[i].record));
  }
  if (!messages.empty()) end_part(messages.size());
  if (jumps == 0) return;
  report.warnings.push_back(std::to_string(jumps) + " clock jump(s): " + first +
                            Format("; only the longest part between jumps is used, %.1f of %.1f s",
                                   1e-9 * static_cast<double>(longest),
                                   SecondsSince(messages.front().record, messages.back().record)));
}

}  // namespace

StampReport CheckStamps(const std::vector<MessageTimes>& messages) {
  StampReport report;
  std::vector<TimeNs> all;
  for (const MessageTimes& message : messages) all.push_back(message.stamp);
  FindClockJumps(messages, MedianPeriod(all), report);
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
