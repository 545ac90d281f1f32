#pragma once

#include <algorithm>
#include <vector>

namespace mlic {

inline int CountTrue(const std::vector<bool>& flags) {
  return static_cast<int>(std::count(flags.begin(), flags.end(), true));
}

}  // namespace mlic
