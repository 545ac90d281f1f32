#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "mlic_ros/programs/calibration_job.h"
#include "mlic_ros/programs/program.h"

namespace mlic {

// Exit statuses of `calibrate` and of the node.
std::vector<StatusMeaning> CalibrationStatuses();

// The options of a calibration, one set for `calibrate`, which takes them as arguments, and calibrate.launch,
// which hands them on as parameters.
class JobArguments {
 public:
  JobArguments();
  JobArguments(const JobArguments&) = delete;
  JobArguments& operator=(const JobArguments&) = delete;

  CLI::App& App() { return app_; }

  // Parses the parameters of calibrate_node: parameter(name) gives the value of the option of that name, with
  // _ for -, and nothing where it is not set. `bag` holds several paths separated by blanks, unless all of it
  // is the path of one file. directory: what relative paths start from. InputError for wrong ones.
  void ParseParameters(const std::function<std::string(const std::string&)>& parameter,
                       const std::filesystem::path& directory);

  // The options as parsed. InputError where the matcher cannot be made.
  JobOptions Options() const;

 private:
  CLI::App app_;
  std::filesystem::path directory_;
  std::string rig_, prior_, output_, matcher_ = "classical", matcher_weights_, intrinsics_ = "trajectory";
  std::vector<std::string> bags_;
  double duration_ = 0.0;
  JobOptions options_;
};

}  // namespace mlic
