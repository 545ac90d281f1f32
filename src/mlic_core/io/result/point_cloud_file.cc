#include "mlic_core/io/result/point_cloud_file.h"

#define PCL_NO_PRECOMPILE  // the point type is our own
#include <pcl/io/pcd_io.h>
#include <pcl/point_cloud.h>
#include <pcl/register_point_struct.h>
#include <unistd.h>

#include <cstdint>
#include <string>

#include "mlic_core/common/error.h"

namespace mlic {

// In no anonymous namespace: there clang warns of the operators that the macro defines and nobody calls.
struct PointOfFile {
  float x, y, z, intensity;
  std::int32_t lidar, plane;
};

}  // namespace mlic

POINT_CLOUD_REGISTER_POINT_STRUCT(mlic::PointOfFile,
                                  (float, x, x)(float, y, y)(float, z, z)(float, intensity, intensity)(
                                      std::int32_t, lidar, lidar)(std::int32_t, plane, plane))

namespace mlic {

void WritePointCloudFile(const std::filesystem::path& path, const std::vector<MapPoint>& points) {
  pcl::PointCloud<PointOfFile> cloud;
  cloud.reserve(points.size());
  for (const MapPoint& point : points) {
    const Eigen::Vector3f& p = point.position;
    cloud.push_back({p.x(), p.y(), p.z(), point.intensity, point.lidar, point.plane});
  }
  // Whole or not at all; the process id keeps two programs that write into one directory apart.
  std::filesystem::path temporary = path;
  temporary += ".tmp" + std::to_string(getpid());
  try {
    if (pcl::PCDWriter().writeBinary(temporary.string(), cloud) != 0) throw pcl::IOException("not written");
    std::filesystem::rename(temporary, path);
  } catch (const std::exception&) {
    std::error_code ignored;
    std::filesystem::remove(temporary, ignored);
    throw InputError(path.string() + ": cannot be written; check the permissions and the free space there");
  }
}

}  // namespace mlic
