#pragma once

#include <chrono>
#include <ctime>

#include "mlic_core/result/result.h"

namespace mlic {

// Time since it was made: by the clock on the wall, and of all the program's threads together, which other
// programs on the machine do not add to.
class Stopwatch {
 public:
  void Read(StageSummary* stage) const {
    stage->seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    stage->processor_seconds = static_cast<double>(std::clock() - processor_start_) / CLOCKS_PER_SEC;
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::clock_t processor_start_ = std::clock();
};

}  // namespace mlic
