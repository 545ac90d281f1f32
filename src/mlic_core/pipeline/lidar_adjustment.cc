#include "mlic_core/pipeline/lidar_adjustment.h"

#include <algorithm>
#include <cstdio>

#include "mlic_core/association/plane_association.h"
#include "mlic_core/initialization/guess_check.h"
#include "mlic_core/initialization/map_alignment.h"
#include "mlic_core/pipeline/stage_names.h"

namespace mlic {

Adjustment AdjustEachLidar(Adjustment adjustment, const AdjustmentContext& context) {
  constexpr int kRounds = 3;  // from: guard, the joint rounds go on from there
  // Of a LiDAR's planes, so many lie on the base LiDAR's where its map is laid into that one's.
  constexpr double kLaid = 0.1;  // from: measured, trials, LiDAR, open 427: 0.01 do by chance
  const std::size_t lidars = context.rig.lidars.size(), base = adjustment.base_lidar;
  std::vector<std::size_t> order{base};
  for (std::size_t l = 0; l < lidars; ++l) {
    if (l != base && !adjustment.rejected_lidars[l]) order.push_back(l);
  }
  JointProblem& problem = adjustment.problem;
  std::vector<PlaneNoise>& noise = adjustment.plane_noise;
  const std::vector<LidarTerms> given = problem.lidars;
  std::vector<MapPlane> of_base;
  for (std::size_t k = 0; k < order.size(); ++k) {
    const std::size_t lidar = order[k];
    const SensorCalibration before = adjustment.state.lidars[lidar];
    double share_before = 0.0, share = 0.0;
    std::vector<bool> only(lidars, false);
    only[lidar] = true;
    for (std::size_t l = 0; l < lidars; ++l) problem.lidars[l].fixed = given[l].fixed || l != lidar;
    problem.fix_trajectory = lidar != base;
    for (int round = 0; round < kRounds; ++round) {
      AssociateWithPlanes(context, only, kFewPoints, false, &adjustment);
      const std::vector<MapPlane>& planes = problem.drives[0].planes.planes;
      if (lidar != base && round == 0) share_before = ShareOfPlanes(of_base, planes, RigidTransform{});
      if (lidar != base && round == kRounds - 1) share = ShareOfPlanes(of_base, planes, RigidTransform{});
      SolveAdjustment(context.monitor.cancellation, &adjustment);
      noise = MeasurePlaneNoise(problem.drives, adjustment.state, noise);
      context.monitor.progress((static_cast<double>(k) + (round + 1.0) / kRounds) /
                               static_cast<double>(order.size()));
    }
    if (lidar == base) of_base = problem.drives[0].planes.planes;
    if (share_before > kLaid && share < 0.5 * share_before) adjustment.state.lidars[lidar] = before;
    char text[160];
    std::snprintf(text, sizeof(text), "%s: %zu planes, points off them by %.1f mm",
                  context.rig.lidars[lidar].name.c_str(), problem.drives[0].planes.planes.size(),
                  1e3 * noise[lidar].Sigma(1.0));
    context.monitor.line(text);
    ShowAdjustment(context, stage_names::kEachLidar, static_cast<int>(k), adjustment);
  }
  problem.lidars = given;
  problem.fix_trajectory = false;
  // LiDARs still disagree by what their own adjustments could not see; the common map must bridge that.
  for (PlaneNoise& of_lidar : noise) of_lidar.floor = std::max(of_lidar.floor, 0.05);
  return adjustment;
}

void RejectLostLidars(const AdjustmentContext& context, Adjustment* adjustment) {
  for (std::size_t l = 0; l < adjustment->unaligned_lidars.size(); ++l) {
    const LidarConfig& config = context.rig.lidars[l];
    if (!adjustment->unaligned_lidars[l] || config.fixed ||
        !IsLostFromGuess(config, adjustment->state.lidars[l].T_imu_sensor)) {
      continue;
    }
    adjustment->rejected_lidars[l] = adjustment->problem.lidars[l].fixed = true;
    context.monitor.line(config.name + ": rejected, its planes lead far from where it started");
  }
}

}  // namespace mlic
