#include "mlic_core/inspection/stamp_findings.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mlic_core/imu/imu_samples.h"
#include "mlic_core/ingest/drive_notes.h"
#include "mlic_core/lidar/point_time.h"

namespace mlic {
namespace {

// Constants of this file, from: definition, the limits of docs/inspection.md.
constexpr double kLeastLostShare = 0.02;     // of the messages: fewer are no matter
constexpr double kMostLostShare = 0.5;       // of the messages
constexpr double kFewestPeriodsOfGap = 5.0;  // LiDARs and cameras
constexpr double kShortestGap = 0.5;         // s, likewise
constexpr double kLeastDisorder = 0.001;     // of the messages
constexpr double kDriftSigmas = 5.0;         // of the fitted drift
constexpr double kDriftWarn = 1e-3;          // s over the drive
constexpr double kDriftFail = 0.05;          // s over the drive
constexpr double kOverlapPass = 0.9;         // of the IMU's time
constexpr double kOverlapFail = 0.1;         // of the IMU's time

struct Rates {
  double pass, fail;  // Hz
};

Rates RatesOf(SensorKind kind) {
  switch (kind) {
    case SensorKind::kImu:
      return {50.0, 5.0};
    case SensorKind::kLidar:
      return {4.5, 1.0};
    case SensorKind::kCamera:
      return {2.0, 0.5};
  }
  return {};
}

// Sorted, each once.
std::vector<TimeNs> UniqueStamps(const std::vector<MessageTimes>& messages) {
  std::vector<TimeNs> stamps;
  for (const MessageTimes& m : messages) stamps.push_back(m.stamp);
  std::sort(stamps.begin(), stamps.end());
  stamps.erase(std::unique(stamps.begin(), stamps.end()), stamps.end());
  return stamps;
}

Finding RateFinding(const SensorTimes& sensor, double period) {
  const Rates rates = RatesOf(sensor.kind);
  const std::string limit = "at least " + Number(rates.pass) + " Hz";
  if (period <= 0.0) {
    return {Grade::kFail, sensor.name,
            "rate",       "all stamps are the same",
            limit,        "let the driver stamp each message with its time of measurement"};
  }
  const double rate = 1.0 / period;
  const Grade grade = rate < rates.fail ? Grade::kFail : rate < rates.pass ? Grade::kWarn : Grade::kPass;
  return {grade, sensor.name, "rate", Number(rate, "%.2f") + " Hz", limit, "raise the driver's rate"};
}

// On the recorder's clock, so that jumps of the stamps are none.
Finding GapFinding(const SensorTimes& sensor, double period, TimeNs begin) {
  const double longest = sensor.kind == SensorKind::kImu
                             ? LongestBridgedPeriod(period)
                             : std::max(kShortestGap, kFewestPeriodsOfGap * period);
  std::vector<double> places;
  double total = 0.0, worst = 0.0;
  const auto& messages = sensor.messages;
  for (std::size_t i = 1; i < messages.size(); ++i) {
    // Delivered late and in a burst, messages leave a gap in one clock only.
    const double gap = std::min(SecondsSince(messages[i - 1].record, messages[i].record),
                                std::abs(SecondsSince(messages[i - 1].stamp, messages[i].stamp)));
    if (gap <= longest) continue;
    places.push_back(SecondsSince(begin, messages[i - 1].record));
    total += gap;
    worst = std::max(worst, gap);
  }
  const std::string limit = "none over " + Number(longest, "%.3g") + " s";
  if (places.empty()) return {Grade::kPass, sensor.name, "gaps", "none", limit, ""};
  const double length = SecondsSince(messages.front().record, messages.back().record);
  return {total > kMostLostShare * length ? Grade::kFail : Grade::kWarn,
          sensor.name,
          "gaps",
          std::to_string(places.size()) + ", " + Number(total, "%.2f") + " s in all, the longest " +
              Number(worst, "%.2f") + " s, " + PlacesText(places),
          limit,
          "check cable, driver and disk; leave the stretch out by --start and --duration"};
}

Finding LossFinding(const SensorTimes& sensor, const std::vector<TimeNs>& stamps, double period) {
  std::size_t lost = 0;
  for (std::size_t i = 1; period > 0.0 && i < stamps.size(); ++i) {
    const double gap = SecondsSince(stamps[i - 1], stamps[i]);
    // A jump of the clock is no loss.
    if (gap > 1.5 * period && gap < kShortestGap + kFewestPeriodsOfGap * period)
      lost += static_cast<std::size_t>(std::llround(gap / period)) - 1;
  }
  const double share = static_cast<double>(lost) / static_cast<double>(lost + stamps.size());
  const Grade grade = share > kMostLostShare    ? Grade::kFail
                      : share > kLeastLostShare ? Grade::kWarn
                                                : Grade::kPass;
  return {grade,
          sensor.name,
          "lost messages",
          std::to_string(lost) + " singly, " + Number(100.0 * share, "%.1f") + " %",
          Number(100.0 * kLeastLostShare) + " %",
          "record on a faster disk or with a larger buffer (rosbag record -b), check the network"};
}

Finding OrderFinding(const SensorTimes& sensor, std::size_t unique_stamps) {
  std::size_t late = 0;
  TimeNs latest = sensor.messages.front().stamp;
  for (const MessageTimes& m : sensor.messages) {
    if (m.stamp < latest) ++late;
    latest = std::max(latest, m.stamp);
  }
  const std::size_t doubled = sensor.messages.size() - unique_stamps;
  const double share = static_cast<double>(late + doubled) / static_cast<double>(sensor.messages.size());
  return {share > kLeastDisorder ? Grade::kWarn : Grade::kPass,
          sensor.name,
          "order",
          std::to_string(late) + " out of order, " + std::to_string(doubled) + " with a repeated stamp",
          Number(100.0 * kLeastDisorder) + " % of the messages",
          "they are sorted and dropped; look for two drivers or relays on one topic"};
}

Finding JumpFinding(const SensorTimes& sensor, const ClockFit& clock, TimeNs begin) {
  const std::string limit = "none over 5 ms that the recording's own delays do not hide";
  if (clock.jumps.empty()) {
    return {Grade::kPass, sensor.name, "clock jumps", "none", limit, ""};
  }
  std::vector<double> places;
  double largest = 0.0;
  for (const ClockJump& jump : clock.jumps) {
    places.push_back(SecondsSince(begin, sensor.messages[jump.index].record));
    if (std::abs(jump.step) > std::abs(largest)) largest = jump.step;
  }
  return {Grade::kWarn,
          sensor.name,
          "clock jumps",
          std::to_string(places.size()) + ", the largest " + Number(1e3 * largest, "%+.1f") + " ms, " +
              PlacesText(places),
          limit,
          "only the longest part between jumps is used; synchronise the clock before recording"};
}

Findings ArrivalFindings(const SensorTimes& sensor, const ClockFit& clock) {
  if (!clock.stamped_on_arrival) return {};
  return {{Grade::kWarn, sensor.name, "stamps", "taken on arrival: as irregular as the recording",
           "the device's own time", "let the device stamp (PTP, hardware trigger); the time offset suffers"}};
}

}  // namespace

ClockFit ClockOf(const SensorTimes& sensor) {
  if (sensor.messages.size() >= 2) return FitClock(sensor.messages);
  ClockFit clock;
  clock.drift_sigma_ppm = std::numeric_limits<double>::infinity();
  return clock;
}

Findings StampFindings(const SensorTimes& sensor, const ClockFit& clock, TimeNs begin) {
  if (sensor.messages.size() < 2) {
    return {{Grade::kFail, sensor.name, "messages", std::to_string(sensor.messages.size()), "a whole drive",
             "check that the driver runs and the topic is recorded"}};
  }
  const std::vector<TimeNs> stamps = UniqueStamps(sensor.messages);
  const double period = MedianPeriod(stamps);
  Findings findings{RateFinding(sensor, period)};
  if (period <= 0.0) return findings;
  findings.push_back(GapFinding(sensor, period, begin));
  findings.push_back(LossFinding(sensor, stamps, period));
  findings.push_back(OrderFinding(sensor, stamps.size()));
  findings.push_back(JumpFinding(sensor, clock, begin));
  Append(ArrivalFindings(sensor, clock), &findings);
  return findings;
}

Findings DriftFindings(const SensorTimes& sensor, const ClockFit& clock, const ClockFit& imu_clock) {
  const double drift = clock.drift_ppm - imu_clock.drift_ppm;
  const double sigma = std::hypot(clock.drift_sigma_ppm, imu_clock.drift_sigma_ppm);
  if (!std::isfinite(sigma)) return {};
  const double length = SecondsSince(sensor.messages.front().record, sensor.messages.back().record);
  const double sum = 1e-6 * std::abs(drift) * length;
  const bool shown = std::abs(drift) > kDriftSigmas * sigma;
  const Grade grade = !shown || sum < kDriftWarn ? Grade::kPass
                      : sum < kDriftFail         ? Grade::kWarn
                                                 : Grade::kFail;
  return {{grade, sensor.name, "clock drift to the IMU",
           Number(drift, "%.1f") + " +- " + Number(sigma, "%.1f") + " ppm, " + Number(1e3 * sum, "%.1f") +
               " ms over the drive",
           Number(1e3 * kDriftWarn) + " ms over the drive",
           "synchronise the clocks (PTP, GNSS), or calibrate a shorter part"}};
}

Findings OverlapFindings(const SensorTimes& sensor, const SensorTimes& imu) {
  if (sensor.messages.size() < 2 || imu.messages.size() < 2) return {};
  const std::vector<TimeNs> own = UniqueStamps(sensor.messages), reference = UniqueStamps(imu.messages);
  const double length = std::max(1e-9, SecondsSince(reference.front(), reference.back()));
  const double late = SecondsSince(reference.front(), own.front());
  const double early = SecondsSince(own.back(), reference.back());
  const double common =
      SecondsSince(std::max(own.front(), reference.front()), std::min(own.back(), reference.back()));
  const double share = std::max(0.0, common / length);
  const Grade grade = share < kOverlapFail   ? Grade::kFail
                      : share < kOverlapPass ? Grade::kWarn
                                             : Grade::kPass;
  const std::string remedy = share < kOverlapFail
                                 ? "set the clocks to one epoch (PTP, NTP, GNSS) and record again"
                                 : "start all drivers before the recording; look why the sensor stops";
  return {{grade, sensor.name, "time in common with the IMU",
           Number(std::max(0.0, common), "%.1f") + " of " + Number(length, "%.1f") + " s, begins " +
               Number(late, "%+.2f") + " s after it and ends " + Number(early, "%+.2f") + " s before it",
           "at least " + Number(100.0 * kOverlapPass) + " %", remedy}};
}

}  // namespace mlic
