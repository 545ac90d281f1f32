#pragma once

#include <string>
#include <utility>
#include <vector>

namespace mlic {

// A file that a calibration was made of, and the hash of its content (ContentHash; of a recording, of its
// size and samples).
struct RunInput {
  std::string path;  // absolute
  std::string hash;
};

// Of what, by what and how a calibration was made.
struct RunRecord {
  std::string version;  // of MLIC
  std::string command;  // that gives the same again; without threads and output directory
  std::vector<RunInput> inputs;
  std::vector<std::pair<std::string, std::string>> options;  // names and values, the defaults too
};

}  // namespace mlic
