#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <vector>

#include "mlic_core/camera/tracks/tracks.h"
#include "mlic_core/sensors/camera_model.h"

namespace mlic {

// Fills the tables of an empty database that COLMAP made: one camera, an image NUMBER.png with its keypoints
// for each keyframe, and the matches as verified ones. Throws InputError where the file cannot be written.
void FillColmapDatabase(const std::filesystem::path& path, const CameraIntrinsics& camera,
                        const std::vector<std::vector<Eigen::Vector2f>>& keypoints,
                        const std::vector<PairMatches>& matches);

}  // namespace mlic
