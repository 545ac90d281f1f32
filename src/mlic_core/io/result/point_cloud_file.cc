#include "mlic_core/io/result/point_cloud_file.h"

#include <cstring>

#include "mlic_core/io/text_file.h"

namespace mlic {

void WritePointCloudFile(const std::filesystem::path& path, const std::vector<MapPoint>& points) {
  constexpr std::size_t kPointBytes = 24;  // from: structural
  const std::string count = std::to_string(points.size());
  std::string content =
      "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z intensity lidar plane\n"
      "SIZE 4 4 4 4 4 4\nTYPE F F F F I I\nCOUNT 1 1 1 1 1 1\nWIDTH " +
      count + "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + count + "\nDATA binary\n";
  const std::size_t header = content.size();
  content.resize(header + kPointBytes * points.size());
  char* out = content.data() + header;
  for (const MapPoint& point : points) {
    const std::int32_t indices[2] = {point.lidar, point.plane};
    std::memcpy(out, point.position.data(), 12);
    std::memcpy(out + 12, &point.intensity, 4);
    std::memcpy(out + 16, indices, 8);
    out += kPointBytes;
  }
  WriteFileAtomically(path, content);
}

}  // namespace mlic
