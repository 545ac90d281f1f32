#include "mlic_core/pipeline/run_plan.h"

#include "mlic_core/pipeline/joint_adjustment.h"
#include "mlic_core/pipeline/stage_names.h"

namespace mlic {
namespace {

// Shares of this file, from: measured, drives of a car with four LiDARs and of a handheld rig with a
// LiDAR and a camera, one thread. One is a tenth of the time of a LiDAR's odometry.

void PlanLidars(double lidars, bool cameras, std::vector<PlannedStage>* plan) {
  plan->push_back({stage_names::kOdometry, 10.0 * lidars});
  plan->push_back({stage_names::kInitialization, 1.5});
  if (lidars > 1.0) plan->push_back({stage_names::kEachLidar, 2.5 * lidars});
  // With cameras it need not settle as far.
  plan->push_back({NameOf(Landmarks::kNone), (cameras ? 13.0 : 30.0) * lidars});
}

void PlanCameras(const Rig& rig, const CalibrationOptions& options, std::vector<PlannedStage>* plan) {
  const double cameras = static_cast<double>(rig.cameras.size());
  const double sensors = cameras + static_cast<double>(rig.lidars.size());
  const bool map = !rig.lidars.empty();
  plan->push_back({stage_names::kFeatures, 5.0 * cameras});
  plan->push_back({stage_names::kTracks, 12.0 * cameras});
  if (options.intrinsics == IntrinsicsStart::kColmap) plan->push_back({stage_names::kColmap, 30.0 * cameras});
  plan->push_back({map ? stage_names::kCameras : stage_names::kInitialization, 3.0 * cameras});
  if (map && cameras > 1.0) {
    plan->push_back({stage_names::kFirstSharedTracks, 8.0 * cameras});
    plan->push_back({stage_names::kFirstSharedCameras, 1.0 * cameras});
  }
  plan->push_back({stage_names::kSharedTracks, 25.0 * cameras});
  if (map) plan->push_back({stage_names::kSharedCameras, 1.5 * cameras});
  plan->push_back({NameOf(Landmarks::kTracks), 6.0 * sensors});
  if (map) plan->push_back({NameOf(Landmarks::kTracksAndMap), 12.0 * sensors});
}

}  // namespace

std::vector<PlannedStage> PlanRun(const Rig& rig, const CalibrationOptions& options) {
  std::vector<PlannedStage> plan{{stage_names::kLoading, 1.0}};
  if (!rig.lidars.empty()) PlanLidars(static_cast<double>(rig.lidars.size()), !rig.cameras.empty(), &plan);
  if (!rig.cameras.empty()) PlanCameras(rig, options, &plan);
  const double sensors = static_cast<double>(rig.lidars.size() + rig.cameras.size());
  plan.push_back({stage_names::kHalves, 2.0 * sensors});
  plan.push_back({stage_names::kResult, 1.0});
  return plan;
}

}  // namespace mlic
