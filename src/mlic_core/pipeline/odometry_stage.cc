#include "mlic_core/pipeline/odometry_stage.h"

#include <cmath>
#include <cstdio>
#include <string>
#include <utility>

#include "mlic_core/pipeline/stage_names.h"

namespace mlic {

std::vector<DriveOdometry> OdometryStage(const StageContext& context) {
  StageClock stage(stage_names::kOdometry, context);
  const Rig& rig = context.rig;
  std::vector<DriveOdometry> odometry;
  const double share = 1.0 / static_cast<double>(context.dataset.drives.size());
  for (const Drive& drive : context.dataset.drives) {
    const double done = share * static_cast<double>(odometry.size());
    const std::string name = "odometry_" + std::to_string(odometry.size() + 1);
    DriveOdometry of_drive;
    if (context.Load(name, &of_drive)) {
      stage.TakeOver(stage.lines());
    } else {
      of_drive = RunDriveOdometry(rig, drive, context.cancellation,
                                  [&](double f) { stage.Progress(done + share * f); });
      context.Save(name, of_drive);
    }
    odometry.push_back(std::move(of_drive));
    for (std::size_t l = 0; l < rig.lidars.size(); ++l) {
      const AngularRateAlignment& a = odometry.back().alignments[l];
      char line[200];
      std::snprintf(
          line, sizeof(line), "%s: offset %.2f ms, agrees with the gyroscope to %.3f deg (correlation %.3f)",
          rig.lidars[l].name.c_str(), 1e3 * a.time_offset, a.residual_rms * 180.0 / M_PI, a.peak_correlation);
      stage.Line(a.valid ? line : rig.lidars[l].name + ": " + a.failure);
    }
  }
  return odometry;
}

}  // namespace mlic
