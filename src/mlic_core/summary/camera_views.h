#pragma once

#include <vector>

#include "mlic_core/problem/joint_problem.h"
#include "mlic_core/problem/state.h"
#include "mlic_core/result/observer.h"
#include "mlic_core/result/result.h"
#include "mlic_core/sensors/measurements.h"

namespace mlic {

// What the cameras see of the landmarks, for displays and pictures.

// At most `largest` landmarks of the first drive, spread evenly, in the frame of `origin` (origin * map).
std::vector<LandmarkMark> MarkLandmarks(const LandmarkSet& landmarks, const CalibrationState& state,
                                        const RigidTransform& origin, std::size_t largest);

// For each camera with landmarks the image of the first drive that sees the most of them (the earliest of
// equals).
std::vector<CameraView> ChooseViews(const Rig& rig, const Drive& drive, const CalibrationState& state,
                                    const LandmarkSet& landmarks);

// The images that the landmarks of all drives were seen in.
std::vector<CameraKeyframes> UsedKeyframes(const Rig& rig, const Dataset& dataset,
                                           const std::vector<DriveTerms>& drives);

}  // namespace mlic
