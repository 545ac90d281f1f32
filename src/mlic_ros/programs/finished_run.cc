#include "mlic_ros/programs/finished_run.h"

#include <algorithm>
#include <fstream>
#include <sstream>
#include <vector>

#include "mlic_core/common/error.h"
#include "mlic_core/io/content_hash.h"
#include "mlic_core/io/rig/rig_file.h"
#include "mlic_core/io/text_file.h"

namespace mlic {
namespace {

namespace fs = std::filesystem;

std::string SizeAndTime(const fs::path& path) {
  return std::to_string(fs::file_size(path)) + " " +
         std::to_string(fs::last_write_time(path).time_since_epoch().count());
}

// Every file of the directory but the log and what lies under stages.
std::string ListResults(const fs::path& directory) {
  std::vector<std::string> lines;
  for (auto at = fs::recursive_directory_iterator(directory); at != fs::recursive_directory_iterator();
       ++at) {
    if (at->path() == directory / "stages") at.disable_recursion_pending();
    if (!at->is_regular_file() || at->path() == directory / "log.txt") continue;
    lines.push_back(fs::relative(at->path(), directory).string() + " " + SizeAndTime(at->path()) + "\n");
  }
  std::sort(lines.begin(), lines.end());
  std::string text;
  for (const std::string& line : lines) text += line;
  return text;
}

fs::path NoteOf(const fs::path& directory) { return directory / "stages" / "finished.txt"; }

}  // namespace

std::string InputKey(const JobOptions& options) {
  ContentHash hash;
  try {
    hash.Add(SizeAndTime(fs::read_symlink("/proc/self/exe")));
    hash.Add(ReadFile(options.rig));
    for (const CameraConfig& camera : LoadRigFile(options.rig).cameras) {
      const fs::path mask = options.rig.parent_path() / camera.mask;
      if (!camera.mask.empty() && fs::exists(mask)) hash.Add(SizeAndTime(mask));
    }
    for (const fs::path& bag : options.bags) hash.Add(fs::absolute(bag).string()).AddFile(bag);
  } catch (const fs::filesystem_error& error) {
    throw InputError(error.path1().string() + ": cannot be read (" + error.code().message() + ")");
  }
  hash.Add(std::to_string(options.load.start));
  hash.Add(options.load.duration ? std::to_string(*options.load.duration) : "all");
  hash.Add(std::to_string(static_cast<int>(options.calibration.intrinsics)));
  if (options.calibration.matcher) hash.Add(options.calibration.matcher->Name());
  return hash.Text();
}

std::optional<JobOutcome> FindFinishedRun(const fs::path& directory, const std::string& key) {
  std::ifstream file(NoteOf(directory));
  std::string found_key, verdict, refusal;
  std::getline(file, found_key);
  std::getline(file, verdict);
  std::getline(file, refusal);
  if (!file || found_key != key) return std::nullopt;
  std::ostringstream results;
  results << file.rdbuf();
  try {
    if (results.str() != ListResults(directory)) return std::nullopt;
  } catch (const fs::filesystem_error&) {
    return std::nullopt;
  }
  return JobOutcome{verdict == "trusted", refusal};
}

void NoteFinishedRun(const fs::path& directory, const std::string& key, const JobOutcome& outcome) {
  WriteFileAtomically(NoteOf(directory), key + "\n" + (outcome.trusted ? "trusted" : "refused") + "\n" +
                                             outcome.refusal + "\n" + ListResults(directory));
}

}  // namespace mlic
