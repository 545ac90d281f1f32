#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "mlic_core/pipeline/options.h"
#include "mlic_ros/bag/bag_loader.h"

namespace mlic {

struct JobOptions {
  std::filesystem::path rig;
  std::filesystem::path prior;     // an earlier calibration.yaml; empty: none
  std::vector<std::string> added;  // sensors beside which the prior's are held; none: all are estimated
  std::vector<std::filesystem::path> bags;
  std::filesystem::path output;  // directory
  LoadOptions load;
  CalibrationOptions calibration;
  std::filesystem::path matcher_weights;  // of calibration.matcher; empty: the classical one
  int threads = 0;                        // 0: one for each core; from: structural
  bool fresh = false;  // do the work even where a finished run of the same inputs left its results
};

}  // namespace mlic
