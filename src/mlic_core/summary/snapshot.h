#pragma once

#include <string>
#include <vector>

#include "mlic_core/problem/observations.h"
#include "mlic_core/problem/state.h"
#include "mlic_core/result/observer.h"
#include "mlic_core/result/result.h"
#include "mlic_core/uncertainty/adjustment.h"

namespace mlic {

// T_map_normalised: the first pose of the IMU at the origin, looking along with yaw zero.
RigidTransform MapOrigin(const SplitSpline& trajectory);

// origin * T_map_imu every `period` seconds.
std::vector<StampedPose> SampleTrajectory(const Drive& drive, const SplitSpline& trajectory,
                                          const RigidTransform& origin, double period);

// The first drive's points on planes, at most `largest` of them, spread evenly.
std::vector<MapPoint> SampleMap(const CalibrationState& state, const PlaneAssociation& planes,
                                const RigidTransform& origin, std::size_t largest);

// The adjustment as observers see it: the first drive's map (thinned out), planes, trajectory and landmarks.
// Without sigmas before the first joint solve.
CalibrationSnapshot MakeSnapshot(const std::string& stage, int iteration, const Rig& rig,
                                 const Dataset& dataset, const Adjustment& adjustment);

// Cameras that were found on the adjustment's trajectory, of which it does not know yet, with the first
// drive's landmarks.
CalibrationSnapshot MakeSnapshotOfCameras(const std::string& stage, const Rig& rig, const Dataset& dataset,
                                          const Adjustment& adjustment,
                                          const std::vector<CameraCalibration>& cameras,
                                          const LandmarkSet& landmarks);

}  // namespace mlic
