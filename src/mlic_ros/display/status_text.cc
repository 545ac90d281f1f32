#include "mlic_ros/display/status_text.h"

#include <cmath>

#include "mlic_core/common/duration_text.h"

namespace mlic {

bool IsFound(std::uint8_t state) { return state != SensorStatus::WAITING && state != SensorStatus::REJECTED; }

std::string VerdictWord(const Status& status) {
  switch (status.state) {
    case Status::TRUSTED:
      return "TRUSTED";
    case Status::PARTIAL:
      return "PARTIAL";
    case Status::REFUSED:
      return "REFUSED";
    case Status::FAILED:
      return "FAILED";
    case Status::INTERRUPTED:
      return "INTERRUPTED";
    default:
      return status.paused ? "PAUSED" : "RUNNING";
  }
}

std::array<float, 3> VerdictColour(const Status& status) {
  switch (status.state) {
    case Status::TRUSTED:
      return {0.30f, 0.80f, 0.40f};
    case Status::PARTIAL:
      return {0.95f, 0.70f, 0.20f};
    case Status::REFUSED:
    case Status::FAILED:
      return {0.95f, 0.35f, 0.30f};
    default:
      return {0.75f, 0.80f, 0.90f};
  }
}

std::string StageLine(const Status& status) {
  if (status.state != Status::RUNNING) return VerdictWord(status);
  if (status.stage_number == 0) return status.stage;
  return "stage " + std::to_string(status.stage_number) + " of " + std::to_string(status.stage_count) + ": " +
         status.stage;
}

std::string ShownRoundLine(const Status& status) {
  std::string line = status.blinks ? "guess and first map by turns" : "";
  if (status.shown_round == 0) return line;
  if (!line.empty()) line += ", ";
  return line + "round " + std::to_string(status.shown_round) + " of " + std::to_string(status.rounds) +
         " is shown";
}

std::string ProgressLine(const Status& status) {
  const std::string done = std::to_string(std::lround(100.0 * status.run_progress)) + " %";
  if (status.state != Status::RUNNING) return done;
  if (status.seconds_left < 0.0f) return done + ", time left not known yet";
  return done + ", about " + DurationText(status.seconds_left) + " left";
}

}  // namespace mlic
