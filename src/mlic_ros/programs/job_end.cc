#include "mlic_ros/programs/job_end.h"

#include <cmath>
#include <cstdio>
#include <exception>

#include "mlic_core/common/error.h"
#include "mlic_core/common/join.h"
#include "mlic_core/io/report/report_next_step.h"
#include "mlic_core/io/report/report_verdict.h"
#include "mlic_core/io/text_file.h"
#include "mlic_ros/programs/program.h"

namespace mlic {
namespace {

namespace fs = std::filesystem;

// Of sensors or pairs; empty where all of their directions are observable.
template <typename Results>
std::string UnobservableOf(const std::vector<Results>& results) {
  std::size_t count = 0;
  for (const Results& result : results) count += result.unobservable.size();
  if (count == 0) return "";
  return "; " + std::to_string(count) + " unobservable direction" + (count == 1 ? "" : "s") +
         ", see the report";
}

// The sensors that are given: how many, their worst sigmas.
std::string Given(const CalibrationResult& result) {
  const LargestSigmas worst = FindLargestSigmas(result);
  const std::size_t count = result.sensors.size();
  const std::string rotation = worst.rotation > 0.0 ? ShortNumber(worst.rotation * 180.0 / M_PI, 2) + " deg"
                                                    : "no IMU axis of rotation observable";
  const std::string translation = worst.translation > 0.0 ? ShortNumber(1e3 * worst.translation, 2) + " mm"
                                                          : "no IMU axis of translation observable";
  return std::to_string(count) + (count == 1 ? " sensor" : " sensors") + ", worst sigma " + rotation + ", " +
         translation + ", " + ShortNumber(1e3 * worst.time_offset, 2) + " ms" +
         UnobservableOf(result.sensors);
}

std::string GivenPairs(const CalibrationResult& result) {
  const LargestSigmas worst = FindLargestSigmas(result);
  const std::size_t count = result.pairs.size();
  return std::to_string(count) + (count == 1 ? " pair" : " pairs") + " of sensors about " + result.root +
         ", worst sigma " + ShortNumber(worst.rotation * 180.0 / M_PI, 2) + " deg, " +
         ShortNumber(1e3 * worst.translation, 2) + " mm" + UnobservableOf(result.pairs);
}

JobEnd Failure(int status, const std::string& reason, const fs::path& log, const std::string& advice) {
  return {status,
          {reason, "log: " + (log.empty() ? "none, nothing was written" : AbsolutePath(log)),
           "to do: " + advice}};
}

}  // namespace

JobEnd EndWithResult(const CalibrationResult& result, const fs::path& directory) {
  const std::string report = "report: " + AbsolutePath(directory / "report.html");
  const std::string use = "use it: " + UseCommand(directory);
  switch (result.verdict) {
    case Verdict::kTrusted:
      return {kTrusted, {"TRUSTED: " + Given(result), report, use}};
    case Verdict::kPartial:
      if (!result.root.empty()) {
        return {kPartial,
                {"PARTIAL: " + GivenPairs(result) + ". Not tied to the IMU: " + Joined(result.reasons, "; "),
                 report, use}};
      }
      return {kPartial,
              {"PARTIAL: " + Given(result) + ". Rejected: " + Joined(result.reasons, "; "), report, use}};
    case Verdict::kRefused:
      break;
  }
  const std::string why =
      result.reasons.empty() ? "a check failed, see the log" : Joined(result.reasons, "; ");
  return {kRefused, {"REFUSED: " + why, report, "to do: " + Advice(result).front()}};
}

JobEnd EndWithException(const fs::path& log) {
  const auto failure = [&](const std::string& what) {
    return Failure(kFailure, "FAILED: internal failure: " + what, log,
                   "the same command goes on after the last finished stage; if it fails again, report it "
                   "with the log");
  };
  try {
    throw;
  } catch (const InputError& error) {
    return Failure(kBadInput, std::string("BAD INPUT: ") + error.what(), log,
                   "mend what the first of these lines names, then give the same command again");
  } catch (const Cancelled&) {
    return Failure(kInterrupted, "INTERRUPTED: the run was interrupted, no result was written", log,
                   "the same command goes on after the last finished stage");
  } catch (const std::bad_alloc&) {
    return Failure(kFailure, "FAILED: out of memory", log,
                   "give --duration for a shorter part of the drive, or fewer sensors (enabled: false)");
  } catch (const std::exception& error) {
    return failure(error.what());
  } catch (...) {
    return failure("unknown");
  }
}

std::string LastLinesText(const JobEnd& end) {
  std::string text;
  for (const std::string& line : end.lines) text += line + "\n";
  return text;
}

void PrintLastLines(const JobEnd& end) { std::fputs(LastLinesText(end).c_str(), stderr); }

}  // namespace mlic
