#include "mlic_ros/programs/job_log.h"

#include <spdlog/fmt/fmt.h>
#include <spdlog/sinks/basic_file_sink.h>
#include <spdlog/sinks/stdout_sinks.h>

#include <cstdio>

#include "mlic_core/common/error.h"
#include "mlic_core/geometry/so3.h"

namespace mlic {
namespace {

constexpr double kSecondsBetweenLines = 2.0;  // from: structural

double Seconds(std::chrono::steady_clock::duration duration) {
  return std::chrono::duration<double>(duration).count();
}

}  // namespace

JobLog::JobLog(const std::filesystem::path& directory, bool append, JobObserver& display)
    : display_(display) {
  try {
    auto file =
        std::make_shared<spdlog::sinks::basic_file_sink_mt>((directory / kFileName).string(), !append);
    auto terminal = std::make_shared<spdlog::sinks::stderr_sink_mt>();
    terminal->set_pattern("%v");
    file->set_pattern("%Y-%m-%d %H:%M:%S.%e %l: %v");
    logger_ = std::make_shared<spdlog::logger>("mlic", spdlog::sinks_init_list{terminal, file});
    file_logger_ = std::make_shared<spdlog::logger>("mlic_file", file);
  } catch (const std::exception& error) {
    throw InputError("output directory " + directory.string() + ": cannot be written (" + error.what() +
                     "); choose another with --output");
  }
  logger_->flush_on(spdlog::level::info);
  file_logger_->flush_on(spdlog::level::info);
}

void JobLog::FileOnly(bool good, const std::string& line) {
  file_logger_->log(good ? spdlog::level::info : spdlog::level::err, line);
}

void JobLog::OnProgress(const std::string& stage, double fraction) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    const Clock::time_point now = Clock::now();
    const bool new_stage = stage != stage_;
    if (new_stage) {
      stage_ = stage;
      stage_start_ = now;
      shown_fraction_ = 0.0;
    }
    const bool due = Seconds(now - last_shown_) >= kSecondsBetweenLines && fraction > shown_fraction_;
    if (new_stage || due) {
      char text[80];
      const double passed = Seconds(now - stage_start_);
      if (fraction > 0.02 && passed > 0.5) {
        std::snprintf(text, sizeof(text), "%3.0f %%, %.0f s left", 100.0 * fraction,
                      passed * (1.0 - fraction) / fraction);
      } else {
        std::snprintf(text, sizeof(text), "%3.0f %%", 100.0 * fraction);
      }
      logger_->info("[{}] {}", stage, text);
      last_shown_ = now;
      shown_fraction_ = fraction;
    }
  }
  display_.OnProgress(stage, fraction);
}

void JobLog::OnSnapshot(const CalibrationSnapshot& snapshot) {
  file_logger_->info("{} {}: cost {:.6g}, {} points, {} planes", snapshot.stage, snapshot.iteration,
                     snapshot.cost, snapshot.points.size(), snapshot.planes.size());
  display_.OnSnapshot(snapshot);
}

void JobLog::OnMessage(const std::string& line) {
  Line(line);
  display_.OnMessage(line);
}

void JobLog::OnResult(const CalibrationResult& result) {
  for (const SensorResult& sensor : result.sensors) {
    const Eigen::Vector3d& p = sensor.calibration.T_imu_sensor.translation;
    const Eigen::Vector3d rpy = ToRollPitchYaw(sensor.calibration.T_imu_sensor.rotation) * 180.0 / M_PI;
    const Eigen::Vector3d degrees = sensor.sigma.rotation * 180.0 / M_PI;
    Line(fmt::format(
        "{}: xyz [{:.4f}, {:.4f}, {:.4f}] m, rpy [{:.3f}, {:.3f}, {:.3f}] deg, offset {:.3f} ms; sigma "
        "[{:.1f}, {:.1f}, {:.1f}] mm, [{:.4f}, {:.4f}, {:.4f}] deg, {:.3f} ms",
        sensor.name, p.x(), p.y(), p.z(), rpy.x(), rpy.y(), rpy.z(), 1e3 * sensor.calibration.time_offset,
        1e3 * sensor.sigma.translation.x(), 1e3 * sensor.sigma.translation.y(),
        1e3 * sensor.sigma.translation.z(), degrees.x(), degrees.y(), degrees.z(),
        1e3 * sensor.sigma.time_offset));
  }
  for (const PairResult& pair : result.pairs) {
    if (result.root.empty()) break;
    const Eigen::Vector3d& p = pair.T_a_b.translation;
    const Eigen::Vector3d rpy = ToRollPitchYaw(pair.T_a_b.rotation) * 180.0 / M_PI;
    const Eigen::Vector3d sigma = 1e3 * pair.sigma.translation;
    const Eigen::Vector3d degrees = pair.sigma.rotation * 180.0 / M_PI;
    Line(
        fmt::format("{}/{}: xyz [{:.4f}, {:.4f}, {:.4f}] m, rpy [{:.3f}, {:.3f}, {:.3f}] deg; sigma "
                    "[{:.1f}, {:.1f}, {:.1f}] mm, [{:.4f}, {:.4f}, {:.4f}] deg",
                    pair.a, pair.b, p.x(), p.y(), p.z(), rpy.x(), rpy.y(), rpy.z(), sigma.x(), sigma.y(),
                    sigma.z(), degrees.x(), degrees.y(), degrees.z()));
  }
  for (const std::string& warning : result.warnings) Warning("warning: " + warning);
  display_.OnResult(result);
}

}  // namespace mlic
