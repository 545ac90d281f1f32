#include "mlic_core/pipeline/run_plan.h"

#include "mlic_core/pipeline/joint_adjustment.h"

namespace mlic {
namespace {

// Shares of this file, from: measured, drives of a car with four LiDARs and of a handheld rig with a
// LiDAR and a camera, one thread. One is a tenth of the time of a LiDAR's odometry.

void PlanLidars(double lidars, bool cameras, std::vector<PlannedStage>* plan) {
  plan->push_back({"LiDAR odometry", 10.0 * lidars});
  plan->push_back({"initialisation", 1.5});
  if (lidars > 1.0) plan->push_back({"plane adjustment of each LiDAR", 2.5 * lidars});
  // With cameras it need not settle as far.
  plan->push_back({NameOf(Landmarks::kNone), (cameras ? 13.0 : 30.0) * lidars});
}

void PlanCameras(const Rig& rig, const CalibrationOptions& options, std::vector<PlannedStage>* plan) {
  const double cameras = static_cast<double>(rig.cameras.size());
  const double sensors = cameras + static_cast<double>(rig.lidars.size());
  const bool map = !rig.lidars.empty();
  plan->push_back({"image features", 5.0 * cameras});
  plan->push_back({"tracks of each camera", 12.0 * cameras});
  if (options.intrinsics == IntrinsicsStart::kColmap)
    plan->push_back({"intrinsics by COLMAP", 30.0 * cameras});
  plan->push_back({map ? "camera initialisation" : "initialisation", 3.0 * cameras});
  if (map && cameras > 1.0) {
    plan->push_back({"first tracks across cameras", 8.0 * cameras});
    plan->push_back({"cameras on first shared tracks", 1.0 * cameras});
  }
  plan->push_back({"tracks across cameras", 25.0 * cameras});
  if (map) plan->push_back({"cameras on shared tracks", 1.5 * cameras});
  plan->push_back({NameOf(Landmarks::kTracks), 6.0 * sensors});
  if (map) plan->push_back({NameOf(Landmarks::kTracksAndMap), 12.0 * sensors});
}

}  // namespace

std::vector<PlannedStage> PlanRun(const Rig& rig, const CalibrationOptions& options) {
  std::vector<PlannedStage> plan{{"loading", 1.0}};
  if (!rig.lidars.empty()) PlanLidars(static_cast<double>(rig.lidars.size()), !rig.cameras.empty(), &plan);
  if (!rig.cameras.empty()) PlanCameras(rig, options, &plan);
  const double sensors = static_cast<double>(rig.lidars.size() + rig.cameras.size());
  plan.push_back({"halves of the drive", 2.0 * sensors});
  plan.push_back({"result", 1.0});
  return plan;
}

}  // namespace mlic
