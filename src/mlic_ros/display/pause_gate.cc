#include "mlic_ros/display/pause_gate.h"

namespace mlic {

void PauseGate::Set(bool paused) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (paused == paused_) return;
  if (paused) {
    since_ = Clock::now();
  } else {
    before_ += Clock::now() - since_;
  }
  paused_ = paused;
  changed_.notify_all();
}

bool PauseGate::IsPaused() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return paused_;
}

double PauseGate::PausedSeconds() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  const Clock::duration now = paused_ ? Clock::now() - since_ : Clock::duration::zero();
  return std::chrono::duration<double>(before_ + now).count();
}

void PauseGate::Wait() {
  // A signal handler cannot notify: the token is looked at as often as long loops look at it.
  constexpr std::chrono::milliseconds kBetweenLooks(100);  // from: definition, CancellationToken
  std::unique_lock<std::mutex> lock(mutex_);
  while (paused_ && !cancellation_.IsCancelled()) changed_.wait_for(lock, kBetweenLooks);
}

}  // namespace mlic
