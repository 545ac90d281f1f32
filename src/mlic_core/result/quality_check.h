#pragma once

#include <string>

namespace mlic {

// One thing that could be wrong with a calibration, and whether it is (docs/method.md, section 12, says how
// each is measured).
struct QualityCheck {
  enum class Bound { kMost, kLeast };  // what the limit is of values that pass

  std::string name;    // what is looked at: "convergence"
  std::string sensor;  // its name; empty: the whole
  double value = 0.0;
  double limit = 0.0;
  std::string unit;
  Bound bound = Bound::kMost;
  bool refuses = false;  // a failure is a reason against the calibration, else a warning
  std::string failure;   // what a failure means, one line for people
  std::string remedy;    // what to do about it
  // Also where the value is not a number.
  bool Passed() const { return bound == Bound::kMost ? value <= limit : value >= limit; }
};

}  // namespace mlic
