#include "mlic_ros/programs/run_record.h"

#include <algorithm>

#include "mlic_core/io/content_hash.h"
#include "mlic_core/io/rig/rig_file.h"
#include "mlic_core/io/text_file.h"
#include "mlic_ros/programs/program.h"

namespace mlic {
namespace {

namespace fs = std::filesystem;

RunInput InputOf(const fs::path& path) { return {AbsolutePath(path), ContentHash().AddContent(path).Text()}; }

}  // namespace

RunRecord RecordRun(const JobOptions& options) {
  RunRecord run;
  run.version = Version();
  run.command = "rosrun mlic calibrate";
  const auto add = [&](const std::string& option, const std::string& value) {
    run.command += " --" + option + " " + ShellQuoted(value);
  };
  const auto add_file = [&](const std::string& option, const fs::path& path) {
    add(option, AbsolutePath(path));
    run.inputs.push_back(InputOf(path));
  };
  add_file("rig", options.rig);
  for (const CameraConfig& camera : LoadRigFile(options.rig).cameras) {
    const fs::path mask = options.rig.parent_path() / camera.mask;
    if (!camera.mask.empty() && fs::exists(mask)) run.inputs.push_back(InputOf(mask));
  }
  if (!options.prior.empty()) add_file("prior", options.prior);
  for (const std::string& name : options.added) add("add", name);
  for (const fs::path& bag : options.bags) add_file("bag", bag);
  const std::string start = ShortNumber(options.load.start, 12);
  const std::string duration = options.load.duration ? ShortNumber(*options.load.duration, 12) : "0";
  const bool colmap = options.calibration.intrinsics == IntrinsicsStart::kColmap;
  const std::string intrinsics = colmap ? "colmap" : "trajectory";
  if (options.load.start != 0.0) add("start", start);
  if (options.load.duration) add("duration", duration);
  if (colmap) add("intrinsics", intrinsics);
  if (!options.matcher_weights.empty()) {
    add("matcher", "learned");
    add("matcher-weights", AbsolutePath(options.matcher_weights));
  }
  run.options = {{"start", start}, {"duration", duration}, {"intrinsics", intrinsics}};
  run.options.emplace_back("matcher",
                           options.calibration.matcher ? options.calibration.matcher->Name() : "classical");
  return run;
}

std::vector<std::string> SharedInputs(const RunRecord& run, const RunRecord& earlier,
                                      const std::vector<fs::path>& bags) {
  std::vector<std::string> shared;
  for (const fs::path& bag : bags) {
    for (const RunInput& input : run.inputs) {
      const auto is_same = [&](const RunInput& other) { return other.hash == input.hash; };
      if (input.path == AbsolutePath(bag) &&
          std::any_of(earlier.inputs.begin(), earlier.inputs.end(), is_same)) {
        shared.push_back(bag.string());
      }
    }
  }
  return shared;
}

}  // namespace mlic
