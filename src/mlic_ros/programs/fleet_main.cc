// fleet --bags LIST --rig RIG.yaml --output DIR [--slurm] [-- OPTION OF CALIBRATE ...]: calibrates a rig from
// each of many drives by itself, here or on Slurm, and says whether they agree. Exit statuses: 0 all are
// trusted, 2 none gives anything, 4 some do, others see program.h.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "mlic_core/common/duration_text.h"
#include "mlic_core/common/error.h"
#include "mlic_core/common/printable.h"
#include "mlic_core/evaluation/repeatability.h"
#include "mlic_core/io/output_directory.h"
#include "mlic_core/io/result/result_file.h"
#include "mlic_core/io/result/result_names.h"
#include "mlic_core/io/rig/rig_file.h"
#include "mlic_core/io/text_file.h"
#include "mlic_ros/programs/drive_list.h"
#include "mlic_ros/programs/drive_runs.h"
#include "mlic_ros/programs/interrupt.h"
#include "mlic_ros/programs/job_end.h"
#include "mlic_ros/programs/program.h"

namespace mlic {
namespace {

namespace fs = std::filesystem;

struct FleetOptions {
  fs::path list, rig, output;
  int at_once = 1;  // from: structural
  // Of each drive; 0: an equal part of this machine's, or what Slurm gives. from: structural
  int threads = 0;
  bool slurm = false;
  std::vector<std::string> of_calibrate;
};

// One drive and what became of it.
struct FleetDrive {
  ListedDrive drive;
  fs::path directory;
  std::string line;  // the verdict with the worst sigma, or the reason
  std::optional<CalibrationResult> result;
};

// calibrate says it at the beginning of one of its last lines.
std::string ReasonIn(const fs::path& log) {
  std::string reason = "FAILED: ended without a word";
  std::istringstream lines(fs::exists(log) ? ReadFile(log) : "");
  for (std::string line; std::getline(lines, line);) {
    for (const char* word : {"BAD INPUT: ", "FAILED: ", "INTERRUPTED: ", "calibrate: "}) {
      if (line.rfind(word, 0) == 0) reason = Printable(line);
    }
  }
  return reason + " (log: " + log.string() + ")";
}

void TakeEnd(const DriveRun& run, FleetDrive* drive) {
  if (run.status == kTrusted || run.status == kRefused || run.status == kPartial) {
    drive->result = ReadCalibrationFile(drive->directory / "calibration.yaml");
    drive->line = EndWithResult(*drive->result, drive->directory).lines.front();
  } else {
    drive->line = ReasonIn(run.log);
  }
}

// Says on the terminal how far the fleet is.
class Progress {
 public:
  explicit Progress(std::size_t drives) : drives_(drives) {}
  void Ended(const FleetDrive& drive) {
    ++ended_;
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - begin_;
    const double left = passed.count() * static_cast<double>(drives_ - ended_) / static_cast<double>(ended_);
    std::fprintf(stderr, "fleet: %zu of %zu drives%s: %s: %s\n", ended_, drives_,
                 ended_ == drives_ ? "" : (", about " + DurationText(left) + " left").c_str(),
                 drive.drive.name.c_str(), drive.line.c_str());
  }

 private:
  std::size_t drives_, ended_ = 0;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

std::vector<FleetDrive> FindDrives(const FleetOptions& options) {
  LoadRigFile(options.rig);  // what is wrong with it is said once, before all work
  std::vector<FleetDrive> drives;
  for (ListedDrive& drive : ReadDriveList(options.list)) {
    drives.push_back({std::move(drive), {}, "", {}});
    drives.back().directory = AbsolutePath(options.output / "drives" / drives.back().drive.name);
    OutputDirectory::Check(drives.back().directory, "calibrate");
  }
  return drives;
}

std::vector<DriveRun> RunsOf(const FleetOptions& options, const std::vector<FleetDrive>& drives) {
  const std::string calibrate = fs::read_symlink("/proc/self/exe").replace_filename("calibrate").string();
  const int cores = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  const int threads = options.threads > 0 ? options.threads : std::max(1, cores / options.at_once);
  std::vector<DriveRun> runs;
  for (const FleetDrive& drive : drives) {
    DriveRun run;
    run.log = AbsolutePath(options.output / "logs" / (drive.drive.name + ".txt"));
    run.command = {calibrate, "--rig", AbsolutePath(options.rig), "--output", drive.directory.string()};
    const auto add = [&](const std::string& name, const std::string& value) {
      run.command.insert(run.command.end(), {name, value});
    };
    for (const fs::path& bag : drive.drive.bags) add("--bag", AbsolutePath(bag));
    if (!options.slurm) add("--threads", std::to_string(threads));
    run.command.insert(run.command.end(), options.of_calibrate.begin(), options.of_calibrate.end());
    runs.push_back(std::move(run));
  }
  return runs;
}

// One line for each drive; the line of text in double quotes, as CSV has it.
std::string CsvOf(const std::vector<FleetDrive>& drives) {
  const auto quoted = [](const std::string& text) {
    std::string cell = "\"";
    for (const char c : text) cell += c == '"' ? "\"\"" : std::string(1, c);
    return cell + "\"";
  };
  std::string csv = "drive,verdict,directory,line\n";
  for (const FleetDrive& drive : drives) {
    csv += quoted(drive.drive.name) + "," + (drive.result ? VerdictName(drive.result->verdict) : "none") +
           "," + quoted(drive.directory.string()) + "," + quoted(drive.line) + "\n";
  }
  return csv;
}

// How far drives agree in what they give to the IMU; nothing of fewer than two.
std::optional<Repeatability> AgreementOf(const std::vector<FleetDrive>& drives) {
  std::vector<CalibrationResult> calibrations;
  for (const FleetDrive& drive : drives) {
    if (drive.result && !drive.result->sensors.empty() && drive.result->root.empty()) {
      calibrations.push_back(*drive.result);
    }
  }
  if (calibrations.size() < 2) return std::nullopt;
  return MeasureRepeatability(calibrations, nullptr);
}

int Conclude(const std::vector<FleetDrive>& drives, OutputDirectory* output) {
  const std::optional<Repeatability> agreement = AgreementOf(drives);
  output->Replace([&](const fs::path& directory) {
    WriteFileAtomically(directory / "fleet.csv", CsvOf(drives));
    if (agreement) WriteFileAtomically(directory / "repeatability.csv", CsvOf(*agreement));
  });
  for (const FleetDrive& drive : drives)
    std::printf("%s: %s\n", drive.drive.name.c_str(), drive.line.c_str());
  if (agreement) std::fputs(TableOf(*agreement).c_str(), stdout);
  const auto count = [&](auto&& holds) { return std::count_if(drives.begin(), drives.end(), holds); };
  const auto trusted = count([](const FleetDrive& d) { return d.result && d.result->Trusted(); });
  const auto given =
      count([](const FleetDrive& d) { return d.result && d.result->verdict != Verdict::kRefused; });
  std::printf("%td of %zu drives are trusted, %td partial; %s\n", trusted, drives.size(), given - trusted,
              (output->Path() / "fleet.csv").c_str());
  if (trusted == static_cast<std::ptrdiff_t>(drives.size())) return kTrusted;
  return given > 0 ? kPartial : kRefused;
}

int CalibrateFleet(const FleetOptions& options, const CancellationToken& cancellation) {
  std::vector<FleetDrive> drives = FindDrives(options);
  OutputDirectory output(options.output, "fleet");
  std::error_code failed;
  fs::create_directories(options.output / "logs", failed);
  if (failed) throw InputError((options.output / "logs").string() + ": cannot be made: " + failed.message());
  std::vector<DriveRun> runs = RunsOf(options, drives);
  Progress progress(drives.size());
  const auto on_end = [&](std::size_t index) {
    TakeEnd(runs[index], &drives[index]);
    progress.Ended(drives[index]);
  };
  if (options.slurm) {
    RunOnSlurm(AbsolutePath(options.output), options.threads, cancellation, on_end, &runs);
  } else {
    RunHere(static_cast<std::size_t>(options.at_once), cancellation, on_end, &runs);
  }
  return Conclude(drives, &output);
}

}  // namespace
}  // namespace mlic

int main(int argc, char** argv) {
  mlic::FleetOptions options;
  CLI::App app("Calibrates a rig from each of many drives by itself, and says whether they agree", "fleet");
  std::string list, rig, output;
  app.add_option("--bags", list,
                 "text file: the bag of one drive on each line, or its bags with blanks between")
      ->required()
      ->type_name("FILE");
  app.add_option("--rig", rig, "rig file: the sensors and their topics")->required()->type_name("FILE");
  app.add_option("--output", output, "directory for the results, empty or new or of an earlier run")
      ->required()
      ->type_name("DIR");
  CLI::Option* slurm = app.add_flag(
      "--slurm", options.slurm,
      "as an array job of Slurm, which takes partition, account and time from SBATCH_ variables");
  app.add_option("--at-once", options.at_once, "drives at a time on this machine")
      ->check(CLI::Range(1, 1024))
      ->excludes(slurm)
      ->type_name("NUMBER")
      ->capture_default_str();
  app.add_option("--threads", options.threads,
                 "threads of each drive; 0: its share of the cores, on Slurm what the cluster gives")
      ->check(CLI::Range(0, 1024))
      ->type_name("NUMBER")
      ->capture_default_str();
  app.add_option("OPTION", options.of_calibrate,
                 "after --: options that each calibrate gets, such as --duration 60")
      ->type_name("TEXT");
  mlic::Describe(app,
                 {{mlic::kTrusted, "all drives are trusted"},
                  {mlic::kRefused, "no drive gives a calibration"},
                  {mlic::kPartial, "some drives do, or give a part"},
                  {mlic::kInterrupted, "interrupted; the same command goes on with what is not finished"}},
                 "rosrun mlic fleet --bags drives.txt --rig rig.yaml --output fleet");
  int status = 0;
  if (!mlic::ParseArguments(app, argc, argv, status)) return status;
  options.list = list;
  options.rig = rig;
  options.output = output;
  const mlic::CancellationToken& cancellation = mlic::CancelOnSignals();
  return mlic::RunProgram("fleet", [&] { return mlic::CalibrateFleet(options, cancellation); });
}
