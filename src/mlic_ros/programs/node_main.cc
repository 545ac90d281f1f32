// calibrate_node: the same work as `calibrate`, shown in RViz. Private parameters: rig, bag (one or several,
// separated by spaces), output, start, duration (0: all), threads, fresh, keep_open (stay after the result,
// for RViz), matcher, matcher_weights.
#include <ros/ros.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <thread>

#include "mlic_core/common/error.h"
#include "mlic_ros/display/ros_display.h"
#include "mlic_ros/programs/calibration_job.h"
#include "mlic_ros/programs/interrupt.h"
#include "mlic_ros/programs/matcher_choice.h"
#include "mlic_ros/programs/program.h"

namespace mlic {
namespace {

JobOptions OptionsFromParameters() {
  ros::NodeHandle parameters("~");
  const auto required = [&](const std::string& name) {
    // roslaunch turns values that look like numbers into numbers.
    XmlRpc::XmlRpcValue value;
    if (!parameters.getParam(name, value) || value.getType() != XmlRpc::XmlRpcValue::TypeString ||
        static_cast<std::string>(value).empty()) {
      throw InputError("parameter " + name + " is missing; give " + name +
                       ":=... to roslaunch mlic calibrate.launch");
    }
    return static_cast<std::string>(value);
  };
  JobOptions options;
  options.rig = required("rig");
  options.output = required("output");
  std::istringstream bags(required("bag"));
  for (std::string bag; bags >> bag;) options.bags.emplace_back(bag);
  options.load.start = parameters.param("start", 0.0);
  const double duration = parameters.param("duration", 0.0);
  if (duration > 0.0) options.load.duration = duration;
  options.threads = parameters.param("threads", 0);
  options.calibration.matcher = ChooseMatcher(parameters.param("matcher", std::string("classical")),
                                              parameters.param("matcher_weights", std::string()));
  options.fresh = true;  // results that lie there already would leave nothing to show
  return options;
}

void WaitUntilClosed(const CancellationToken& cancellation) {
  while (ros::ok() && !cancellation.IsCancelled())
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
}

void WriteStatusFile(int status) {
  const char* path = std::getenv("MLIC_STATUS_FILE");
  if (path != nullptr) std::ofstream(path) << status << "\n";
}

int Run(const CancellationToken& cancellation, RosDisplay& display) {
  std::string log_hint;
  const auto body = [&]() -> int {
    try {
      const JobOptions options = OptionsFromParameters();
      log_hint = LogHint(options);
      const JobOutcome outcome = RunCalibrationJob(options, cancellation, display);
      if (outcome.trusted) return kTrusted;
      std::fprintf(stderr, "calibrate_node: %s\n", outcome.refusal.c_str());
      return kRefused;
    } catch (const std::exception& error) {
      display.OnFailure(error.what());
      throw;
    }
  };
  return RunProgram("calibrate_node", body, [&] { return log_hint; });
}

}  // namespace
}  // namespace mlic

int main(int argc, char** argv) {
  ros::init(argc, argv, "mlic_calibrate", ros::init_options::NoSigintHandler);
  ros::NodeHandle node;
  const mlic::CancellationToken& cancellation = mlic::CancelOnSignals();
  ros::AsyncSpinner spinner(1);
  spinner.start();
  mlic::RosDisplay display(node);
  const int status = mlic::Run(cancellation, display);
  mlic::WriteStatusFile(status);
  ros::NodeHandle parameters("~");
  if (parameters.param("keep_open", false)) {
    mlic::WaitUntilClosed(cancellation);
  } else {
    // Latched messages live as long as their publisher: give subscribers time to receive the last ones.
    ros::WallDuration(parameters.param("linger", 1.0)).sleep();
  }
  return status;
}
