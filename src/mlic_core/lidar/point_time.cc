#include "mlic_core/lidar/point_time.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "mlic_core/common/error.h"
#include "mlic_core/common/order_statistics.h"

namespace mlic {
namespace {

constexpr double kShortestSpan = 0.15;      // of the scan period; from: guard, units differ by 1000
constexpr double kLongestSpan = 1.5;        // from: guard, units differ by 1000
constexpr double kFarthestFromStamp = 2.0;  // of the scan period; from: guard, units differ by 1000

struct Unit {
  double seconds;
  const char* name;
};
constexpr std::array<Unit, 4> kUnits{
    {{1.0, "seconds"}, {1e-3, "milliseconds"}, {1e-6, "microseconds"}, {1e-9, "nanoseconds"}}};

// First point minus stamp, s, if the value were absolute. Whole counts first, or a double would lose the
// digits.
double AbsoluteMinusStamp(double value, double seconds_per_count, TimeNs stamp) {
  const double nanoseconds_per_count = seconds_per_count * 1e9;
  return 1e-9 * static_cast<double>(std::llround(value * nanoseconds_per_count) - stamp);
}

bool FitsRelative(const PointTimeRange& range, double seconds_per_count, double period) {
  const double limit = kFarthestFromStamp * period;
  return std::abs(range.minimum * seconds_per_count) <= limit &&
         std::abs(range.maximum * seconds_per_count) <= limit;
}

bool FitsAbsolute(const PointTimeRange& range, double seconds_per_count, double period) {
  const double limit = kFarthestFromStamp * period;
  return std::abs(AbsoluteMinusStamp(range.minimum, seconds_per_count, range.stamp)) <= limit &&
         std::abs(AbsoluteMinusStamp(range.maximum, seconds_per_count, range.stamp)) <= limit;
}

[[noreturn]] void ThrowNoUnit(double span, double period, const std::string& where) {
  std::ostringstream text;
  text << where << ": the values span " << span << " in a scan, but scans come every " << period
       << " s: expected about " << period << " (seconds), " << period * 1e3 << " (milliseconds), "
       << period * 1e6 << " (microseconds) or " << period * 1e9
       << " (nanoseconds); correct the field or the driver's setting and record again";
  throw InputError(text.str());
}

[[noreturn]] void ThrowNoReference(const PointTimeRange& range, const Unit& unit, double period,
                                   const std::string& where) {
  std::ostringstream text;
  text.precision(15);
  text << where << ": a scan stamped " << 1e-9 * static_cast<double>(range.stamp) << " s has values "
       << range.minimum << " to " << range.maximum << " (" << unit.name
       << "), and their distance from the stamp changes from scan to scan: expected times within "
       << kFarthestFromStamp * period << " s of the header stamp, relative to it or absolute";
  throw InputError(text.str());
}

}  // namespace

double MedianPeriod(std::vector<TimeNs> stamps) {
  std::sort(stamps.begin(), stamps.end());
  std::vector<double> differences;
  for (std::size_t i = 1; i < stamps.size(); ++i) {
    if (stamps[i] > stamps[i - 1]) differences.push_back(SecondsSince(stamps[i - 1], stamps[i]));
  }
  return Median(differences);
}

PointTimeFormat FindPointTimeFormat(const std::vector<PointTimeRange>& ranges, double scan_period,
                                    const std::string& where) {
  std::vector<double> spans;
  for (const PointTimeRange& range : ranges) spans.push_back(range.maximum - range.minimum);
  const double span = Median(spans);
  const Unit* unit = nullptr;
  for (const Unit& candidate : kUnits) {
    const double share = span * candidate.seconds / scan_period;
    if (share >= kShortestSpan && share <= kLongestSpan) unit = &candidate;
  }
  if (unit == nullptr) ThrowNoUnit(span, scan_period, where);

  PointTimeFormat format;
  format.seconds_per_count = unit->seconds;
  const auto most = [&](auto fits) {
    const auto count = std::count_if(ranges.begin(), ranges.end(), fits);
    return 2 * static_cast<std::size_t>(count) > ranges.size();
  };
  if (most([&](const auto& range) { return FitsRelative(range, unit->seconds, scan_period); })) return format;
  if (most([&](const auto& range) { return FitsAbsolute(range, unit->seconds, scan_period); })) {
    format.reference = PointTimeFormat::Reference::kAbsolute;
    return format;
  }
  std::vector<double> differences;
  for (const PointTimeRange& range : ranges) {
    differences.push_back(AbsoluteMinusStamp(range.minimum, unit->seconds, range.stamp));
  }
  format.reference = PointTimeFormat::Reference::kOtherClock;
  format.clock_difference = Median(differences);
  const bool constant = most([&](const auto& range) {
    const double difference = AbsoluteMinusStamp(range.minimum, unit->seconds, range.stamp);
    return std::abs(difference - format.clock_difference) <= 0.5 * scan_period;
  });
  if (!constant) ThrowNoReference(ranges.front(), *unit, scan_period, where);
  return format;
}

bool FitsFormat(const PointTimeFormat& format, const PointTimeRange& range, double scan_period) {
  if ((range.maximum - range.minimum) * format.seconds_per_count > kLongestSpan * scan_period) return false;
  switch (format.reference) {
    case PointTimeFormat::Reference::kStamp:
      return FitsRelative(range, format.seconds_per_count, scan_period);
    case PointTimeFormat::Reference::kAbsolute:
      return FitsAbsolute(range, format.seconds_per_count, scan_period);
    case PointTimeFormat::Reference::kOtherClock:
      return true;  // only differences within the scan are used
  }
  return false;
}

ScanTimeBase TimeBaseOf(const PointTimeFormat& format, const PointTimeRange& range) {
  const double nanoseconds = range.minimum * (format.seconds_per_count * 1e9);
  switch (format.reference) {
    case PointTimeFormat::Reference::kStamp:
      return {range.stamp + std::llround(nanoseconds), range.minimum};
    case PointTimeFormat::Reference::kAbsolute:
      return {std::llround(nanoseconds), range.minimum};
    case PointTimeFormat::Reference::kOtherClock:
      break;
  }
  return {range.stamp, range.minimum};
}

std::string Describe(const PointTimeFormat& format) {
  std::string unit;
  for (const Unit& candidate : kUnits) {
    if (candidate.seconds == format.seconds_per_count) unit = candidate.name;
  }
  switch (format.reference) {
    case PointTimeFormat::Reference::kStamp:
      return unit + " after the header stamp";
    case PointTimeFormat::Reference::kAbsolute:
      return unit + ", absolute";
    case PointTimeFormat::Reference::kOtherClock:
      break;
  }
  std::ostringstream text;
  text.precision(12);
  text << unit << " in a clock " << format.clock_difference
       << " s ahead of the header stamp (the first point of each scan is taken to be at the stamp)";
  return text.str();
}

}  // namespace mlic
