#pragma once

#include <atomic>
#include <functional>
#include <string>

#include "mlic_core/common/error.h"

namespace mlic {

// Set from a signal handler or another thread; long loops call ThrowIfCancelled often (at least every 100
// ms).
class CancellationToken {
 public:
  void Cancel() { cancelled_.store(true, std::memory_order_relaxed); }
  bool IsCancelled() const { return cancelled_.load(std::memory_order_relaxed); }
  void ThrowIfCancelled() const {
    if (IsCancelled()) throw Cancelled();
  }

 private:
  std::atomic<bool> cancelled_{false};
};

// Where long work tells how far it is. Calls may come from any thread.
class ProgressSink {
 public:
  virtual ~ProgressSink() = default;
  // stage: what is being done, for people; fraction: done part of this stage, 0 to 1.
  virtual void OnProgress(const std::string& stage, double fraction) = 0;
};

// Who watches one piece of long work: it may be cancelled, and reports its done share (0 to 1) and lines for
// the log.
struct Monitor {
  const CancellationToken& cancellation;
  std::function<void(double)> progress = [](double) {};
  std::function<void(const std::string&)> line = [](const std::string&) {};
};

}  // namespace mlic
