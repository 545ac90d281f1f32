#pragma once

#include <spdlog/logger.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>

#include "mlic_ros/display/job_observer.h"

namespace mlic {

// Writes the job's log to DIR/log.txt and stderr, with progress lines (stage, percent, remaining time), and
// hands all that it observes on to the display.
class JobLog : public JobObserver {
 public:
  static constexpr const char* kFileName = "log.txt";

  // append: goes on after what an earlier run wrote. Throws InputError when the file cannot be written.
  JobLog(const std::filesystem::path& directory, bool append, JobObserver& display);

  void Line(const std::string& line) { logger_->info(line); }
  void Warning(const std::string& line) { logger_->warn(line); }
  // To the file alone: times, and how the run ended, which the program itself prints. good: no error.
  void FileOnly(bool good, const std::string& line);

  void OnProgress(const std::string& stage, double fraction) override;
  void OnSnapshot(const CalibrationSnapshot& snapshot) override;
  void OnMessage(const std::string& line) override;
  void OnPlan(const std::vector<PlannedStage>& plan) override { display_.OnPlan(plan); }
  void OnRig(const Rig& rig) override { display_.OnRig(rig); }
  void OnResult(const CalibrationResult& result) override;

 private:
  using Clock = std::chrono::steady_clock;

  JobObserver& display_;
  std::shared_ptr<spdlog::logger> logger_, file_logger_;
  std::mutex mutex_;  // progress comes from any thread
  std::string stage_;
  double shown_fraction_ = 0.0;
  Clock::time_point stage_start_, last_shown_;
};

}  // namespace mlic
