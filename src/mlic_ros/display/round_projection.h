#pragma once

#include <vector>

#include "mlic_core/result/observer.h"

namespace mlic {

// The points of the map that a camera sees, cheaply: what lies well behind other points of the same small
// part of the image is left out.
std::vector<ProjectedPoint> ProjectMap(const std::vector<MapPoint>& points,
                                       const RigidTransform& T_map_camera,
                                       const CameraIntrinsics& intrinsics);

}  // namespace mlic
