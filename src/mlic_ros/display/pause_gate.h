#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>

#include "mlic_core/common/progress.h"

namespace mlic {

// Where the threads of a calibration wait while it is paused. They come by whenever they tell their progress.
class PauseGate {
 public:
  explicit PauseGate(const CancellationToken& cancellation) : cancellation_(cancellation) {}

  void Set(bool paused);
  bool IsPaused() const;
  // For how long it was paused, until now.
  double PausedSeconds() const;
  // Returns once it is not paused, or is cancelled.
  void Wait();

 private:
  using Clock = std::chrono::steady_clock;

  const CancellationToken& cancellation_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  bool paused_ = false;
  Clock::time_point since_;
  Clock::duration before_{};  // of earlier pauses
};

}  // namespace mlic
