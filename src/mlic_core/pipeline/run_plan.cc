#include "mlic_core/pipeline/run_plan.h"

#include "mlic_core/pipeline/joint_adjustment.h"

namespace mlic {
namespace {

// Shares of this file, from: measured, percent of the time of a handheld drive of 15 s with a LiDAR and a
// camera, one thread. Each grows with the number of what it works on.

void PlanLidars(double lidars, bool cameras, std::vector<PlannedStage>* plan) {
  plan->push_back({"LiDAR odometry", 4.0 * lidars});
  plan->push_back({"initialisation", 4.0});
  if (lidars > 1.0) plan->push_back({"plane adjustment of each LiDAR", 6.0 * lidars});
  plan->push_back({NameOf(Landmarks::kNone), (cameras ? 12.0 : 30.0) * lidars});
}

void PlanCameras(const Rig& rig, const CalibrationOptions& options, std::vector<PlannedStage>* plan) {
  const double cameras = static_cast<double>(rig.cameras.size());
  const bool map = !rig.lidars.empty();
  plan->push_back({"image features", 3.0 * cameras});
  plan->push_back({"tracks of each camera", 6.0 * cameras});
  if (options.intrinsics == IntrinsicsStart::kColmap)
    plan->push_back({"intrinsics by COLMAP", 20.0 * cameras});
  plan->push_back({map ? "camera initialisation" : "initialisation", 10.0 * cameras});
  if (map && cameras > 1.0) {
    plan->push_back({"first tracks across cameras", 4.0 * cameras});
    plan->push_back({"cameras on first shared tracks", 4.0 * cameras});
  }
  plan->push_back({"tracks across cameras", 8.0 * cameras});
  if (map) plan->push_back({"cameras on shared tracks", 8.0 * cameras});
  plan->push_back({NameOf(Landmarks::kTracks), 20.0 * cameras});
  if (map) plan->push_back({NameOf(Landmarks::kTracksAndMap), 30.0 * cameras});
}

}  // namespace

std::vector<PlannedStage> PlanRun(const Rig& rig, const CalibrationOptions& options) {
  std::vector<PlannedStage> plan{{"loading", 2.0}};
  if (!rig.lidars.empty()) PlanLidars(static_cast<double>(rig.lidars.size()), !rig.cameras.empty(), &plan);
  if (!rig.cameras.empty()) PlanCameras(rig, options, &plan);
  plan.push_back({"halves of the drive", 2.0});
  plan.push_back({"result", 3.0});
  return plan;
}

}  // namespace mlic
