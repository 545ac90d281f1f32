#pragma once

#include <map>
#include <string>

#include "mlic_core/common/progress.h"
#include "mlic_core/result/observer.h"

namespace mlic {

// Interrupts a calibration when a stage begins, or after one of its rounds, and counts what it did.
class Interruption : public CalibrationObserver {
 public:
  // round: -1 for the stage's begin.
  Interruption(std::string stage, int round, CancellationToken* token)
      : stage_(std::move(stage)), round_(round), token_(token) {}

  void OnProgress(const std::string& stage, double fraction) override {
    if (stage == stage_ && round_ < 0) token_->Cancel();
    if (fraction > 0.0) ++steps_[stage];
  }
  void OnSnapshot(const CalibrationSnapshot& snapshot) override {
    ++rounds_[snapshot.stage];
    if (snapshot.stage == stage_ && snapshot.iteration == round_) token_->Cancel();
  }

  // Reports of progress of a stage and of its parts, whose names begin with the stage's.
  int Steps(const std::string& stage) const {
    int sum = 0;
    for (const auto& [name, count] : steps_) sum += name.rfind(stage, 0) == 0 ? count : 0;
    return sum;
  }
  int Rounds(const std::string& stage) const {
    const auto found = rounds_.find(stage);
    return found == rounds_.end() ? 0 : found->second;
  }

 private:
  std::string stage_;
  int round_;
  CancellationToken* token_;
  std::map<std::string, int> steps_, rounds_;
};

}  // namespace mlic
