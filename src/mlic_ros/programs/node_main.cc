// calibrate_node: the same work as `calibrate`, shown in RViz; what calibrate.launch runs. Private
// parameters: the options of `calibrate` with _ for - (bag: several separated by blanks), directory (what
// relative paths start from), rviz and rviz_config, keep_open (stay after the result, for other viewers),
// frame_prefix (of all frames that RViz is shown; mlic).
#include <fcntl.h>
#include <ros/file_log.h>
#include <ros/ros.h>
#include <std_srvs/Trigger.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <thread>

#include "mlic_ros/display/frame_prefix.h"
#include "mlic_ros/display/ros_display.h"
#include "mlic_ros/programs/calibration_job.h"
#include "mlic_ros/programs/interrupt.h"
#include "mlic_ros/programs/job_arguments.h"
#include "mlic_ros/programs/program.h"
#include "mlic_ros/programs/rviz_window.h"
#include "mlic_ros/programs/supervision.h"

namespace mlic {
namespace {

// The value of a private parameter as text, whatever its type; empty where it is not set.
std::string Parameter(const std::string& name) {
  XmlRpc::XmlRpcValue value;
  if (!ros::NodeHandle("~").getParam(name, value)) return "";
  std::ostringstream text;
  value.write(text);
  return text.str();
}

JobOptions OptionsFromParameters() {
  std::string directory = Parameter("directory");
  while (!directory.empty() && directory.back() == '\n') directory.pop_back();  // of the command pwd
  JobArguments arguments;
  arguments.ParseParameters(Parameter, directory);
  return arguments.Options();
}

std::string RvizLog() { return ros::file_log::getLogDirectory() + "/mlic_rviz.log"; }

std::unique_ptr<RvizWindow> OpenRviz() {
  if (!ros::NodeHandle("~").param("rviz", false)) return nullptr;
  auto window = std::make_unique<RvizWindow>(Parameter("rviz_config"), RvizLog());
  if (!window->Problem().empty()) {
    std::fprintf(stderr, "warning: RViz is not started: %s; the calibration goes on without\n",
                 window->Problem().c_str());
  }
  return window;
}

// For scripts, which roslaunch gives no exit status: the status and the last lines.
void WriteStatusFile(const JobEnd& end) {
  const char* path = std::getenv("MLIC_STATUS_FILE");
  if (path == nullptr) return;
  std::ofstream(path) << end.status << "\n" << LastLinesText(end);
}

// From the process that calibrates to the one that supervises it, which says the last lines once more.
class LinesPipe {
 public:
  LinesPipe() { open_ = pipe2(ends_, O_CLOEXEC | O_NONBLOCK) == 0; }
  void Send(const JobEnd& end) const {
    const std::string text = LastLinesText(end);
    if (open_ && write(ends_[1], text.data(), text.size()) < 0) std::perror("calibrate_node: last lines");
  }
  std::string Receive() const {
    char text[1 << 14];  // far more than three lines
    const ssize_t size = open_ ? read(ends_[0], text, sizeof(text)) : 0;
    return size > 0 ? std::string(text, static_cast<std::size_t>(size)) : "";
  }

 private:
  int ends_[2] = {};
  bool open_ = false;
};

void Announce(const JobEnd& end, const LinesPipe& pipe) {
  PrintLastLines(end);
  WriteStatusFile(end);
  pipe.Send(end);
}

// Latched messages live as long as their publisher, so the node stays as long as somebody may look.
void StayForViewers(RvizWindow* rviz) {
  ros::NodeHandle parameters("~");
  const bool keep_open = parameters.param("keep_open", false);
  const auto is_wanted = [&] { return keep_open || (rviz != nullptr && rviz->IsOpen()); };
  if (!is_wanted()) ros::WallDuration(1.0).sleep();  // for subscribers to receive the last messages
  while (is_wanted() && ros::ok() && !WasSignalled()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
}

// /mlic/cancel: what Ctrl-C does to the calibration; the node stays for viewers.
ros::ServiceServer OfferCancel(ros::NodeHandle& node, const std::atomic<bool>& has_ended) {
  using std_srvs::Trigger;
  return node.advertiseService<Trigger::Request, Trigger::Response>(
      "/mlic/cancel", [&has_ended](Trigger::Request&, Trigger::Response& response) {
        response.success = !has_ended;
        response.message = has_ended ? "the calibration has ended already" : "the calibration ends";
        if (!has_ended) CancelOnRequest();
        return true;
      });
}

int RunNode(int argc, char** argv, const LinesPipe& pipe) {
  ros::init(argc, argv, "mlic_calibrate", ros::init_options::NoSigintHandler);
  ros::NodeHandle node;
  const CancellationToken& cancellation = CancelOnSignals();
  const std::unique_ptr<RvizWindow> rviz = OpenRviz();
  RosDisplay display(node, ToFramePrefix(ros::NodeHandle("~").param<std::string>("frame_prefix", "mlic")),
                     cancellation);
  std::atomic<bool> has_ended{false};
  const ros::ServiceServer cancel = OfferCancel(node, has_ended);
  ros::AsyncSpinner spinner(1);
  spinner.start();
  const JobEnd end = RunCalibrationJob(
      [&display] {
        JobOptions options = OptionsFromParameters();
        display.SetOutput(options.output);
        return options;
      },
      cancellation, display);
  has_ended = true;
  if (rviz != nullptr && rviz->IsOpen()) {
    std::fprintf(stderr, "finished; the launch ends when RViz is closed\n");
  } else if (rviz != nullptr && rviz->Problem().empty()) {
    std::fprintf(stderr, "warning: RViz ended before the calibration; what it said: %s\n", RvizLog().c_str());
  }
  Announce(end, pipe);
  StayForViewers(rviz.get());
  return end.status;
}

int ReportDeath(int signal, const LinesPipe& pipe) {
  const JobEnd end{kFailure,
                   {"FAILED: calibrate_node was ended by signal " + std::to_string(signal) +
                        (signal == SIGKILL ? ", which often means that the memory ran out" : ""),
                    "log: log.txt in the output directory",
                    "to do: the same command goes on after the last finished stage; give duration for a "
                    "shorter part if memory is short"}};
  Announce(end, pipe);
  return end.status;
}

}  // namespace
}  // namespace mlic

int main(int argc, char** argv) {
  CLI::App app(
      "The same work as calibrate, shown in RViz: what calibrate.launch starts. Its parameters are the "
      "options "
      "of calibrate with _ for -, and those that the launch file names",
      "calibrate_node");
  bool end_launch = false;
  app.add_flag("--end-launch", end_launch, "end the launch once all is done");
  app.allow_extras();  // ROS's own, such as __name:=
  mlic::Describe(app, mlic::CalibrationStatuses(),
                 "roslaunch mlic calibrate.launch rig:=rig.yaml bag:=drive.bag output:=result");
  int parsed = 0;
  if (!mlic::ParseArguments(app, argc, argv, parsed)) return parsed;
  const mlic::LinesPipe pipe;
  const int status = mlic::Supervise([&] { return mlic::RunNode(argc, argv, pipe); },
                                     [&](int signal) { return mlic::ReportDeath(signal, pipe); });
  if (end_launch) mlic::EndLaunch(pipe.Receive());
  return status;
}
