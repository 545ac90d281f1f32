#pragma once

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <vector>

namespace mlic {

// By how much a sensor's stamps are too early in the course of a drive, beyond offset and drift: of a camera
// whose exposure is automatic, as the middle of its exposure moves against its stamps. Between its times on a
// straight line, before the first and after the last as there. Empty: by nothing.
struct StampCourse {
  std::vector<double> times;   // s, ascending
  std::vector<double> shifts;  // s, of each; mean and slope are zero
  double walk = 0.0;           // s^2/s, variance by which the shift changes with time
  double jitter = 0.0;         // s^2, variance of what each image has of its own

  bool IsEmpty() const { return times.empty(); }
  double At(double time) const {
    if (times.empty() || time <= times.front()) return times.empty() ? 0.0 : shifts.front();
    if (time >= times.back()) return shifts.back();
    const auto next = std::upper_bound(times.begin(), times.end(), time);
    const auto k = static_cast<std::size_t>(std::distance(times.begin(), next));
    const double share = (time - times[k - 1]) / (times[k] - times[k - 1]);
    return (1.0 - share) * shifts[k - 1] + share * shifts[k];
  }
  double MeanSquare() const {
    double sum = 0.0;
    for (const double shift : shifts) sum += shift * shift;
    return times.empty() ? 0.0 : sum / static_cast<double>(times.size());
  }
};

}  // namespace mlic
