#pragma once

#include <filesystem>
#include <vector>

#include "mlic_core/result/coloured_point.h"
#include "mlic_core/result/result.h"

namespace mlic {

// Writes the map as a binary PCD file, version 0.7, fields x y z intensity (float32), lidar and plane
// (int32); at least one point. Throws InputError where it cannot be written.
void WritePointCloudFile(const std::filesystem::path& path, const std::vector<MapPoint>& points);

// The same of coloured points: fields x y z (float32) and rgb, packed as PCL does.
void WriteColouredPointCloudFile(const std::filesystem::path& path, const std::vector<ColouredPoint>& points);

}  // namespace mlic
