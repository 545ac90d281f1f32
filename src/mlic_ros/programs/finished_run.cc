#include "mlic_ros/programs/finished_run.h"

#include <fstream>

#include "mlic_core/common/error.h"
#include "mlic_core/io/content_hash.h"
#include "mlic_core/io/rig/rig_file.h"
#include "mlic_core/io/text_file.h"
#include "mlic_ros/programs/program.h"

namespace mlic {
namespace {

namespace fs = std::filesystem;

std::string SizeAndTime(const fs::path& path) {
  return std::to_string(fs::file_size(path)) + " " +
         std::to_string(fs::last_write_time(path).time_since_epoch().count());
}

// The executable of `calibrate`, also for calibrate_node beside it: they are built of the same parts, and
// each goes on with what the other left.
fs::path Program() {
  const fs::path self = fs::read_symlink("/proc/self/exe"), calibrate = self.parent_path() / "calibrate";
  return fs::exists(calibrate) ? calibrate : self;
}

fs::path NoteOf(const fs::path& directory) { return directory / "stages" / "finished.txt"; }

}  // namespace

std::string InputKey(const JobOptions& options) {
  ContentHash hash;
  try {
    hash.Add(SizeAndTime(Program()));
    hash.Add(ReadFile(options.rig));
    if (!options.prior.empty()) hash.Add(ReadFile(options.prior));
    for (const std::string& name : options.added) hash.Add(name);
    for (const CameraConfig& camera : LoadRigFile(options.rig).cameras) {
      const fs::path mask = options.rig.parent_path() / camera.mask;
      if (!camera.mask.empty() && fs::exists(mask)) hash.Add(SizeAndTime(mask));
    }
    for (const fs::path& bag : options.bags) {
      hash.Add(AbsolutePath(bag)).AddFile(bag);
    }
  } catch (const fs::filesystem_error& error) {
    throw InputError(error.path1().string() + ": cannot be read (" + error.code().message() + ")");
  }
  hash.Add(std::to_string(options.load.start));
  hash.Add(options.load.duration ? std::to_string(*options.load.duration) : "all");
  hash.Add(std::to_string(static_cast<int>(options.calibration.intrinsics)));
  if (options.calibration.matcher) hash.Add(options.calibration.matcher->Name());
  return hash.Text();
}

bool IsFinished(const OutputDirectory& output, const std::string& key) {
  std::ifstream file(NoteOf(output.Path()));
  std::string noted_key, results;
  std::getline(file, noted_key);
  std::getline(file, results);
  return file && noted_key == key && !results.empty() && results == output.ResultsHash();
}

void NoteFinishedRun(const OutputDirectory& output, const std::string& key) {
  WriteFileAtomically(NoteOf(output.Path()), key + "\n" + output.ResultsHash() + "\n");
}

}  // namespace mlic
