#include "mlic_ros/programs/job_arguments.h"

#include <algorithm>

#include "mlic_core/common/error.h"
#include "mlic_ros/programs/matcher_choice.h"
#include "mlic_ros/programs/path_list.h"

namespace mlic {

namespace fs = std::filesystem;

std::vector<StatusMeaning> CalibrationStatuses() {
  return {{kTrusted, "calibrated and trusted"},
          {kRefused, "refused: too little motion, or a failed check; calibration.yaml says why"},
          {kPartial, "partial: some sensors, or pairs of them; the others are named with reasons"},
          {kInterrupted, "interrupted; the same command goes on after the last finished stage"}};
}

JobArguments::JobArguments()
    : app_("Calibrates the LiDARs, the cameras and the IMU of a rig from one recorded drive", "calibrate") {
  app_.add_option("--rig", rig_, "rig file: the sensors and their topics")->required()->type_name("FILE");
  app_.add_option("--bag", bags_, "ROS 1 bag; give it again for more")->required()->type_name("FILE");
  CLI::Option* prior =
      app_.add_option("--prior", prior_, "earlier calibration.yaml: its sensors start there, with its sigmas")
          ->type_name("FILE");
  app_.add_option("--add", options_.added,
                  "sensor to calibrate beside those of the prior, which are held; give it again for more")
      ->needs(prior)
      ->type_name("NAME");
  app_.add_option("--output", output_, "directory for the results, empty or new or of an earlier run")
      ->required()
      ->type_name("DIR");
  app_.add_option("--start", options_.load.start, "leave out the first seconds")
      ->type_name("SECONDS")
      ->capture_default_str();
  app_.add_option("--duration", duration_,
                  "use no more than this many seconds; 0: all, of a long recording the part that shows most")
      ->check(CLI::NonNegativeNumber)
      ->type_name("SECONDS")
      ->capture_default_str();
  app_.add_option(
          "--intrinsics", intrinsics_,
          "where the intrinsics start of cameras with nothing but fov_deg: on the trajectory, or COLMAP")
      ->check(CLI::IsMember({"trajectory", "colmap"}))
      ->capture_default_str();
  app_.add_option("--matcher", matcher_, "what finds the same points in images: classical (SIFT) or learned")
      ->check(CLI::IsMember({"classical", "learned"}))
      ->capture_default_str();
  app_.add_option("--matcher-weights", matcher_weights_,
                  "directory with the networks of the learned matcher, see docs/learned_matcher.md")
      ->type_name("DIR");
  app_.add_option("--threads", options_.threads, "threads to use; 0: one for each core")
      ->check(CLI::Range(0, 1024))
      ->type_name("NUMBER")
      ->capture_default_str();
  app_.add_flag("--fresh", options_.fresh, "do the work even where DIR holds the results of the same inputs");
  Describe(app_, CalibrationStatuses(),
           "rosrun mlic calibrate --rig rig.yaml --bag drive.bag --output result");
}

void JobArguments::ParseParameters(const std::function<std::string(const std::string&)>& parameter,
                                   const fs::path& directory) {
  directory_ = directory;
  std::vector<std::string> arguments;
  for (const CLI::Option* option : app_.get_options()) {
    const std::string name = option->get_lnames().front();
    std::string parameter_name = name;
    std::replace(parameter_name.begin(), parameter_name.end(), '-', '_');
    const std::string value = parameter(parameter_name);
    const bool is_flag = option->get_expected_max() == 0;
    if (value.empty() || name == "help" || name == "version") continue;
    if (is_flag) {
      arguments.push_back("--" + name + "=" + value);
      continue;
    }
    const std::vector<std::string> values =
        name == "bag" ? SplitPaths(value, directory) : std::vector<std::string>{value};
    for (const std::string& one : values) arguments.insert(arguments.end(), {"--" + name, one});
  }
  std::reverse(arguments.begin(), arguments.end());  // as CLI11 takes them
  try {
    app_.parse(arguments);
  } catch (const CLI::ParseError& error) {
    throw InputError(std::string(error.what()) +
                     "; give it to roslaunch mlic calibrate.launch as NAME:=VALUE");
  }
}

JobOptions JobArguments::Options() const {
  JobOptions options = options_;
  options.rig = directory_ / rig_;
  options.output = directory_ / output_;
  if (!prior_.empty()) options.prior = directory_ / prior_;
  for (const std::string& bag : bags_) options.bags.push_back(directory_ / bag);
  if (duration_ > 0.0) {
    options.load.duration = duration_;
  } else {
    options.load.most_telling = true;
  }
  options.calibration.intrinsics =
      intrinsics_ == "colmap" ? IntrinsicsStart::kColmap : IntrinsicsStart::kTrajectory;
  const fs::path weights = matcher_weights_.empty() ? fs::path() : directory_ / matcher_weights_;
  options.calibration.matcher = ChooseMatcher(matcher_, weights.string());
  options.matcher_weights = weights;
  return options;
}

}  // namespace mlic
