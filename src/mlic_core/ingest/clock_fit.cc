#include "mlic_core/ingest/clock_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mlic_core/common/order_statistics.h"

namespace mlic {
namespace {

constexpr double kClockWindow = 2.0;       // s; from: guard, bursts of late messages are shorter
constexpr double kSmallestJump = 5e-3;     // s; from: definition, the limit of an observable time offset
constexpr double kWanders = 4.0;           // of the usual wander; from: guard, sigmas of what is no accident
constexpr std::size_t kFewestWindows = 5;  // for a drift with a scatter; from: guard

std::vector<double> Delays(const std::vector<MessageTimes>& messages) {
  std::vector<double> delays;
  for (const MessageTimes& m : messages) delays.push_back(SecondsSince(m.stamp, m.record));
  return delays;
}

struct WindowDelay {
  double time = 0.0;  // s after the first message, of the message with the least delay
  double delay = 0.0;
};

// The least delay of each window of so many seconds.
std::vector<WindowDelay> LeastDelays(const std::vector<MessageTimes>& messages,
                                     const std::vector<double>& delays, double length = kClockWindow) {
  std::vector<WindowDelay> windows;
  double last = -1.0;
  for (std::size_t i = 0; i < messages.size(); ++i) {
    const double time = SecondsSince(messages.front().record, messages[i].record);
    const double window = std::floor(time / length);
    if (windows.empty() || window != last) {
      windows.push_back({time, delays[i]});
    } else if (delays[i] < windows.back().delay) {
      windows.back() = {time, delays[i]};
    }
    last = window;
  }
  return windows;
}

double Wander(const std::vector<MessageTimes>& messages, const std::vector<double>& delays) {
  constexpr double kFewestWindows = 10.0;  // so that jumps are few among them; from: guard
  const double length = SecondsSince(messages.front().record, messages.back().record);
  const std::vector<WindowDelay> windows =
      LeastDelays(messages, delays, std::clamp(length / kFewestWindows, 1e-3, kClockWindow));
  std::vector<double> differences;
  for (std::size_t i = 1; i < windows.size(); ++i) {
    differences.push_back(std::abs(windows[i].delay - windows[i - 1].delay));
  }
  return Median(std::move(differences));
}

struct DelayRange {
  double least, most;
};

// The least delay that is no accident: a message that overtakes another may bear too late a stamp.
DelayRange RangeOf(std::vector<double> delays) {
  constexpr std::size_t kAccidents = 2;  // among eight messages and more; from: guard
  const std::size_t left_out = std::min(kAccidents, delays.size() / 4);
  std::nth_element(delays.begin(), delays.begin() + static_cast<std::ptrdiff_t>(left_out), delays.end());
  return {delays[left_out], *std::max_element(delays.begin(), delays.end())};
}

// How far the least delay after message `at` lies from the one before it, each over kClockWindow. Near the
// ends, where the least delay is that of few messages, zero unless all of them lie apart from those on the
// other side.
double StepOfLeastDelay(const std::vector<MessageTimes>& messages, const std::vector<double>& delays,
                        std::size_t at) {
  std::size_t begin = at, end = at;
  while (begin > 0 && SecondsSince(messages[begin - 1].record, messages[at].record) < kClockWindow) --begin;
  while (end < messages.size() && SecondsSince(messages[at].record, messages[end].record) < kClockWindow)
    ++end;
  if (begin == at) return 0.0;
  const DelayRange before = RangeOf({delays.begin() + begin, delays.begin() + at});
  const DelayRange after = RangeOf({delays.begin() + at, delays.begin() + end});
  const bool near_end = SecondsSince(messages.front().record, messages[at].record) < 0.5 * kClockWindow ||
                        SecondsSince(messages[at].record, messages.back().record) < 0.5 * kClockWindow;
  if (near_end && before.most > after.least && after.most > before.least) return 0.0;
  return after.least - before.least;
}

// Of candidates within one window the largest step is the jump.
std::vector<ClockJump> FindJumps(const std::vector<MessageTimes>& messages, const std::vector<double>& delays,
                                 double wander) {
  const double limit = std::max(kSmallestJump, kWanders * wander);
  std::vector<ClockJump> jumps;
  for (std::size_t i = 1; i < messages.size(); ++i) {
    const double single = delays[i - 1] - delays[i];  // forward steps of the stamps are positive
    if (std::abs(single) < 0.5 * limit) continue;
    const double step = -StepOfLeastDelay(messages, delays, i);
    if (std::abs(step) < limit || std::abs(single - step) > 0.5 * std::abs(step)) continue;
    const bool same = !jumps.empty() &&
                      SecondsSince(messages[jumps.back().index].record, messages[i].record) < kClockWindow;
    if (!same) {
      jumps.push_back({i, step});
    } else if (std::abs(step) > std::abs(jumps.back().step)) {
      jumps.back() = {i, step};
    }
  }
  return jumps;
}

// Line through the least delays, the jumps taken out.
void FitDrift(const std::vector<MessageTimes>& messages, std::vector<double> delays, ClockFit* fit) {
  for (const ClockJump& jump : fit->jumps) {
    for (std::size_t i = jump.index; i < delays.size(); ++i) delays[i] += jump.step;
  }
  const std::vector<WindowDelay> windows = LeastDelays(messages, delays);
  fit->drift_sigma_ppm = std::numeric_limits<double>::infinity();
  if (windows.size() < kFewestWindows) return;
  const double count = static_cast<double>(windows.size());
  double mean_time = 0.0, mean_delay = 0.0;
  for (const WindowDelay& w : windows) {
    mean_time += w.time / count;
    mean_delay += w.delay / count;
  }
  double moment = 0.0, product = 0.0, squares = 0.0;
  for (const WindowDelay& w : windows) {
    moment += (w.time - mean_time) * (w.time - mean_time);
    product += (w.time - mean_time) * (w.delay - mean_delay);
  }
  const double slope = product / moment;
  for (const WindowDelay& w : windows) {
    const double residual = w.delay - mean_delay - slope * (w.time - mean_time);
    squares += residual * residual;
  }
  fit->drift_ppm = -1e6 * slope;
  fit->drift_sigma_ppm = 1e6 * std::sqrt(squares / (count - 2.0) / moment);
}

// Median deviation of the differences from their median.
double Irregularity(std::vector<double> differences) {
  const double middle = Median(differences);
  for (double& d : differences) d = std::abs(d - middle);
  return Median(std::move(differences));
}

bool IsStampedOnArrival(const std::vector<MessageTimes>& messages, const std::vector<double>& delays) {
  constexpr double kIrregular = 0.005;  // of the period; from: guard, a device's own clock is regular
  constexpr double kAgreement = 0.2;    // of the irregularity; from: guard
  std::vector<double> stamps, records, changes;
  for (std::size_t i = 1; i < messages.size(); ++i) {
    stamps.push_back(SecondsSince(messages[i - 1].stamp, messages[i].stamp));
    records.push_back(SecondsSince(messages[i - 1].record, messages[i].record));
    changes.push_back(delays[i] - delays[i - 1]);
  }
  const double period = Median(stamps), stamp = Irregularity(stamps), record = Irregularity(records);
  return stamp > kIrregular * period && Irregularity(changes) < kAgreement * std::min(stamp, record);
}

}  // namespace

ClockFit FitClock(const std::vector<MessageTimes>& messages) {
  ClockFit fit;
  fit.drift_sigma_ppm = std::numeric_limits<double>::infinity();
  if (messages.size() < 2) return fit;
  const std::vector<double> delays = Delays(messages);
  fit.wander = Wander(messages, delays);
  fit.jumps = FindJumps(messages, delays, fit.wander);
  FitDrift(messages, delays, &fit);
  fit.stamped_on_arrival = IsStampedOnArrival(messages, delays);
  return fit;
}

}  // namespace mlic
