#pragma once

#include <optional>
#include <string>
#include <vector>

#include "mlic_core/common/progress.h"
#include "mlic_core/initialization/camera_on_trajectory.h"
#include "mlic_core/initialization/lidars_alone.h"
#include "mlic_core/summary/pair_assembly.h"

namespace mlic {

struct PlacedCamera {
  CameraPlace place;
  std::string problem;  // why it has no place, naming the camera; empty: it has one
};

// docs/method.md, section 7.7: each camera of alone.rig from its guess by structure, a few of its photos
// against what the tied LiDARs saw about their times. A parked vehicle's one photo shows all. known: of each
// camera, where it is in the map already, if so. state: of the LiDARs, adjusted.
std::vector<PlacedCamera> PlaceCameras(const LidarsAlone& alone, const std::vector<CameraStart>& starts,
                                       const std::vector<std::optional<CameraPlace>>& known,
                                       const CalibrationState& state, const CancellationToken& cancellation);

}  // namespace mlic
