#include "mlic_core/pipeline/run_progress.h"

#include <algorithm>

namespace mlic {
namespace {

// A stage that an earlier run left takes less and says nothing of the pace. from: guard
constexpr double kLeastSeconds = 1.0;
// A stage that says less of itself is taken for one that says nothing. from: guard
constexpr double kLeastFraction = 0.05;
// What a stage that says nothing of itself reaches by its expected time alone. from: guard
constexpr double kMostByTime = 0.9;

}  // namespace

void RunProgress::Report(const std::string& stage, double fraction, double now) {
  const std::size_t part = stage.find(" (");
  const std::string name = stage.substr(0, part);
  if (begun_ > 0 && plan_[begun_ - 1].name == name) {
    if (part == std::string::npos) fraction_ = std::max(fraction_, std::clamp(fraction, 0.0, 1.0));
    return;
  }
  const auto found = std::find_if(plan_.begin() + static_cast<std::ptrdiff_t>(begun_), plan_.end(),
                                  [&](const PlannedStage& planned) { return planned.name == name; });
  if (found == plan_.end()) return;
  if (begun_ > 0 && now - stage_start_ >= kLeastSeconds) {
    measured_seconds_ += now - stage_start_;
    measured_share_ += plan_[begun_ - 1].share;
  }
  begun_ = static_cast<std::size_t>(found - plan_.begin()) + 1;
  stage_start_ = now;
  fraction_ = 0.0;
}

std::optional<double> RunProgress::Pace(double now) const {
  double seconds = measured_seconds_, share = measured_share_;
  if (begun_ > 0 && fraction_ >= kLeastFraction && now - stage_start_ >= kLeastSeconds) {
    seconds += now - stage_start_;
    share += fraction_ * plan_[begun_ - 1].share;
  }
  if (share <= 0.0) return std::nullopt;
  return seconds / share;
}

double RunProgress::ShareOfAll() const {
  double all = 0.0;
  for (const PlannedStage& stage : plan_) all += stage.share;
  return all;
}

double RunProgress::ShareDone(double now) const {
  if (begun_ == 0) return 0.0;
  double done = 0.0;
  for (std::size_t k = 0; k + 1 < begun_; ++k) done += plan_[k].share;
  const double share = plan_[begun_ - 1].share;
  if (fraction_ >= kLeastFraction) return done + share * fraction_;
  const std::optional<double> pace = Pace(now);
  const double by_time = pace && *pace > 0.0 ? (now - stage_start_) / (*pace * share) : 0.0;
  return done + share * std::clamp(by_time, 0.0, kMostByTime);
}

double RunProgress::Done(double now) {
  const double all = ShareOfAll();
  if (all > 0.0) shown_ = std::max(shown_, ShareDone(now) / all);
  return shown_;
}

std::optional<double> RunProgress::SecondsLeft(double now) const {
  const std::optional<double> pace = Pace(now);
  if (!pace) return std::nullopt;
  return *pace * (ShareOfAll() - ShareDone(now));
}

}  // namespace mlic
