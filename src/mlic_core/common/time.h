#pragma once

#include <cmath>
#include <cstdint>

namespace mlic {

// Absolute time as it stands in messages: integer nanoseconds. Double epoch seconds resolve no better than
// 0.2 microseconds, so they are never used for absolute times. Inside a Drive, times are double seconds since
// the drive's epoch (exact to better than 1e-11 s for a day).
using TimeNs = std::int64_t;

inline double SecondsSince(TimeNs epoch, TimeNs time) { return 1e-9 * static_cast<double>(time - epoch); }

inline TimeNs TimeFrom(TimeNs epoch, double seconds) {
  return epoch + static_cast<TimeNs>(std::llround(seconds * 1e9));
}

}  // namespace mlic
