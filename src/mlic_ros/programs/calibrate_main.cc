// calibrate --rig RIG.yaml --bag FILE.bag [--bag MORE.bag] --output DIR: from recording to calibration,
// without a ROS master. Exit statuses: see program.h.
#include "mlic_ros/programs/calibration_job.h"
#include "mlic_ros/programs/interrupt.h"
#include "mlic_ros/programs/job_arguments.h"
#include "mlic_ros/programs/program.h"

int main(int argc, char** argv) {
  mlic::JobArguments arguments;
  int status = 0;
  if (!mlic::ParseArguments(arguments.App(), argc, argv, status)) return status;
  const mlic::CancellationToken& cancellation = mlic::CancelOnSignals();
  mlic::JobObserver no_display;
  const mlic::JobEnd end =
      mlic::RunCalibrationJob([&] { return arguments.Options(); }, cancellation, no_display);
  mlic::PrintLastLines(end);
  return end.status;
}
