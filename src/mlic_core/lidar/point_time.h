#pragma once

#include <string>
#include <vector>

#include "mlic_core/common/time.h"

namespace mlic {

// Drivers write the time of each point in seconds, milliseconds, microseconds or nanoseconds; after the
// header stamp (which may be at the start or, with negative times, at the end of the scan), as absolute time,
// or in a clock of the sensor's own. None of that stands in the message: it is found here from the values
// themselves.

// The smallest and largest raw value of the time field over the valid points of one scan.
struct PointTimeRange {
  TimeNs stamp = 0;  // of the message's header
  double minimum = 0.0;
  double maximum = 0.0;
};

struct PointTimeFormat {
  enum class Reference {
    kStamp,       // point time = header stamp + value
    kAbsolute,    // point time = value, in the stamps' clock
    kOtherClock,  // value runs in another clock: the first point of the scan is taken to be at the header
                  // stamp
  };
  Reference reference = Reference::kStamp;
  double seconds_per_count = 1.0;
  double clock_difference = 0.0;  // kOtherClock: median of (first point - stamp), s
};

// When the points of one scan were measured: point time = start + (value - first_value) * seconds_per_count.
struct ScanTimeBase {
  TimeNs start = 0;
  double first_value = 0.0;
};

// The median of the positive differences between stamps in order, seconds; 0 when there is none.
double MedianPeriod(std::vector<TimeNs> stamps);

// Finds unit and reference from some scans and checks them: the points of a scan must span 0.15 to 1.5 of
// scan_period in exactly one unit, and must lie within two periods of the header stamp, or be at the same
// distance from it in every scan. Throws InputError (starting with `where`, which names topic and field) for
// values that fit nothing.
PointTimeFormat FindPointTimeFormat(const std::vector<PointTimeRange>& ranges, double scan_period,
                                    const std::string& where);

// True when one more scan agrees with the format; scans that do not are left out and counted.
bool FitsFormat(const PointTimeFormat& format, const PointTimeRange& range, double scan_period);

ScanTimeBase TimeBaseOf(const PointTimeFormat& format, const PointTimeRange& range);

// For people, such as "seconds after the header stamp".
std::string Describe(const PointTimeFormat& format);

}  // namespace mlic
