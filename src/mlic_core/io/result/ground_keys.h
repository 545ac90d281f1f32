#pragma once

#include <optional>
#include <string>

#include "mlic_core/io/yaml_reader.h"
#include "mlic_core/result/pose_over_ground.h"

namespace mlic {

// `ground` of calibration.yaml (docs/outputs.md), with its key; empty where there is none.
std::string GroundText(const std::optional<PoseOverGround>& ground);

// root: of the file.
std::optional<PoseOverGround> ReadGround(const YamlReader& root);

}  // namespace mlic
