#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

namespace mlic {

// "40 s", "7 min", "2 h 05 min".
inline std::string DurationText(double seconds) {
  char text[40];
  const long whole = std::lround(std::max(0.0, seconds));
  const long minutes = (whole + 30) / 60;
  if (whole < 90) {
    std::snprintf(text, sizeof(text), "%ld s", whole);
  } else if (minutes < 60) {
    std::snprintf(text, sizeof(text), "%ld min", minutes);
  } else {
    std::snprintf(text, sizeof(text), "%ld h %02ld min", minutes / 60, minutes % 60);
  }
  return text;
}

}  // namespace mlic
