// calibrate --rig RIG.yaml --bag FILE.bag [--bag MORE.bag] --output DIR: from recording to calibration,
// without a ROS master. Exit statuses: see program.h.
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include "mlic_ros/programs/calibration_job.h"
#include "mlic_ros/programs/interrupt.h"
#include "mlic_ros/programs/matcher_choice.h"
#include "mlic_ros/programs/program.h"

int main(int argc, char** argv) {
  mlic::JobOptions options;
  CLI::App app("Calibrates the LiDARs, the cameras and the IMU of a rig from one recorded drive",
               "calibrate");
  std::string rig, output, matcher = "classical", matcher_weights;
  std::vector<std::string> bags;
  app.add_option("--rig", rig, "rig file")->required();
  app.add_option("--bag", bags, "ROS 1 bag; give it again for more")->required();
  app.add_option("--output", output, "directory for the results, made if needed")->required();
  app.add_option("--start", options.load.start, "leave out the first seconds");
  app.add_option("--duration", options.load.duration, "use no more than this many seconds");
  const std::map<std::string, mlic::IntrinsicsStart> starts{
      {"trajectory", mlic::IntrinsicsStart::kTrajectory}, {"colmap", mlic::IntrinsicsStart::kColmap}};
  app.add_option(
         "--intrinsics", options.calibration.intrinsics,
         "where the intrinsics start of cameras with nothing but fov_deg: on the trajectory, or COLMAP")
      ->transform(CLI::CheckedTransformer(starts, CLI::ignore_case));
  app.add_option("--matcher", matcher, "what finds the same points in images: classical (SIFT) or learned")
      ->check(CLI::IsMember({"classical", "learned"}));
  app.add_option("--matcher-weights", matcher_weights,
                 "directory with the networks of the learned matcher, see docs/learned_matcher.md");
  app.add_option("--threads", options.threads, "threads to use; by default all cores")
      ->check(CLI::Range(0, 1024));
  app.add_flag("--fresh", options.fresh, "do the work even where DIR holds the results of the same inputs");
  int status = 0;
  if (!mlic::ParseArguments(app, argc, argv, status)) return status;
  options.rig = rig;
  options.output = output;
  options.bags.assign(bags.begin(), bags.end());

  const mlic::CancellationToken& cancellation = mlic::CancelOnSignals();
  const auto body = [&] {
    options.calibration.matcher = mlic::ChooseMatcher(matcher, matcher_weights);
    mlic::JobObserver no_display;
    const mlic::JobOutcome outcome = mlic::RunCalibrationJob(options, cancellation, no_display);
    if (outcome.trusted) return mlic::kTrusted;
    std::fprintf(stderr, "calibrate: %s\n", outcome.refusal.c_str());
    return mlic::kRefused;
  };
  return mlic::RunProgram("calibrate", body, [&] { return mlic::LogHint(options); });
}
