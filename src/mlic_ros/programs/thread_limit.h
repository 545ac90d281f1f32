#pragma once

#include <tbb/global_control.h>

#include <memory>

namespace mlic {

// All parallel loops within its lifetime use this many threads; 0: one for each core.
class ThreadLimit {
 public:
  explicit ThreadLimit(int threads);

 private:
  std::unique_ptr<tbb::global_control> limit_;
};

}  // namespace mlic
