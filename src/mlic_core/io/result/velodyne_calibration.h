#pragma once

#include <filesystem>
#include <string>

#include "mlic_core/result/point_corrections.h"

namespace mlic {

// velodyne_pointcloud's calibration file (`lasers`, with vert_correction in rad and dist_correction in m of
// each) with a LiDAR's corrections added to it. All that is not a correction stays byte by byte, comments and
// order too. Rings are what the driver calls them: its lasers by their vert_correction, from below.
//
// Ranges go into dist_correction and, where a laser has them, dist_correction_x and dist_correction_y,
// between which and dist_correction the driver interpolates for near points. A first line says what was
// added, as corrections count once: InputError of a file that has it, of one without lasers, and of a ring
// that it has not.
std::string WithCorrections(const std::filesystem::path& file, const std::string& lidar,
                            const PointCorrections& corrections);

}  // namespace mlic
