#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <vector>

namespace mlic {

// One point of a PCD file. Metres, in the file's frame; ring 0 where the file has none.
struct CloudPoint {
  Eigen::Vector3f position;
  float intensity = 0.0f;
  std::uint16_t ring = 0;
};

// Reads a PCD file, version 0.7 (ascii, binary or binary_compressed), with fields x y z, intensity (or
// reflectivity, i), and optionally ring (or channel, line) of any numeric type up to 4 bytes, or F8; other
// fields are passed over, and points that are not finite are left out. The file's VIEWPOINT is not applied:
// points stay in the sensor's frame. Throws InputError, one line with the file.
std::vector<CloudPoint> ReadPointCloudFile(const std::filesystem::path& path);

}  // namespace mlic
