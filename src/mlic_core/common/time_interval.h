#pragma once

namespace mlic {

// [start, end) in seconds, of whatever clock.
struct TimeInterval {
  double start = 0.0;
  double end = 0.0;
  double Duration() const { return end - start; }
  bool Contains(double time) const { return time >= start && time < end; }
};

}  // namespace mlic
