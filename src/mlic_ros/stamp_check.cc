#include "mlic_ros/stamp_check.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "mlic_core/lidar/point_time.h"

namespace mlic {
namespace {

constexpr std::size_t kWindow = 20;       // differences over which a period is measured
constexpr double kPeriodTolerance = 0.1;  // share by which it may differ from the whole recording's
constexpr double kSmallestJump = 0.25;    // s; recording itself delays messages by less

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

// A jump: from one message to the next, stamp and recording time advance by different amounts.
void FindClockJumps(const std::vector<MessageTimes>& messages, StampReport& report) {
  std::size_t jumps = 0;
  std::string first;
  for (std::size_t i = 1; i < messages.size(); ++i) {
    const double stamps = SecondsSince(messages[i - 1].stamp, messages[i].stamp);
    const double records = SecondsSince(messages[i - 1].record, messages[i].record);
    if (std::abs(stamps - records) <= std::max(kSmallestJump, 2.5 * report.period)) continue;
    if (jumps++ == 0) {
      first = Format("stamps advance by %.3f s while recording advances by %.3f s, %.2f s after the start",
                     stamps, records, SecondsSince(messages.front().record, messages[i].record));
    }
  }
  if (jumps > 0) report.warnings.push_back(std::to_string(jumps) + " clock jump(s): " + first);
}

}  // namespace

StampReport CheckStamps(const std::vector<MessageTimes>& messages) {
  StampReport report;
  std::vector<TimeNs> stamps;
  TimeNs latest = messages.empty() ? 0 : messages.front().stamp;
  for (const MessageTimes& message : messages) {
    if (message.stamp < latest) ++report.out_of_order;
    latest = std::max(latest, message.stamp);
    stamps.push_back(message.stamp);
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
  FindClockJumps(messages, report);
  return report;
}

}  // namespace mlic
