#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "mlic_core/pipeline/options.h"
#include "mlic_ros/bag/bag_loader.h"

namespace mlic {

struct JobOptions {
  std::filesystem::path rig;
  std::vector<std::filesystem::path> bags;
  std::filesystem::path output;  // directory
  LoadOptions load;
  CalibrationOptions calibration;
  int threads = 0;     // 0: one for each core; from: structural
  bool fresh = false;  // do the work even where a finished run of the same inputs left its results
};

// How the job ended, where it did not throw.
struct JobOutcome {
  bool trusted = false;
  std::string refusal;  // why it is refused and what to do: one line
};

}  // namespace mlic
