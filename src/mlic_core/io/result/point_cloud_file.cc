#include "mlic_core/io/result/point_cloud_file.h"

#define PCL_NO_PRECOMPILE  // the point type is our own
#include <pcl/io/pcd_io.h>
#include <pcl/point_cloud.h>
#include <pcl/register_point_struct.h>
#include <unistd.h>

#include <cstdint>
#include <cstring>
#include <string>

#include "mlic_core/common/error.h"

namespace mlic {

// In no anonymous namespace: there clang warns of the operators that the macro defines and nobody calls.
struct PointOfFile {
  float x, y, z, intensity;
  std::int32_t lidar, plane;
};
struct ColouredPointOfFile {
  float x, y, z, rgb;
};

}  // namespace mlic

POINT_CLOUD_REGISTER_POINT_STRUCT(mlic::PointOfFile,
                                  (float, x, x)(float, y, y)(float, z, z)(float, intensity, intensity)(
                                      std::int32_t, lidar, lidar)(std::int32_t, plane, plane))
POINT_CLOUD_REGISTER_POINT_STRUCT(mlic::ColouredPointOfFile,
                                  (float, x, x)(float, y, y)(float, z, z)(float, rgb, rgb))

namespace mlic {
namespace {

// Whole or not at all; the process id keeps two programs that write into one directory apart.
template <typename Point>
void WriteCloud(const std::filesystem::path& path, const pcl::PointCloud<Point>& cloud) {
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

}  // namespace

void WritePointCloudFile(const std::filesystem::path& path, const std::vector<MapPoint>& points) {
  pcl::PointCloud<PointOfFile> cloud;
  cloud.reserve(points.size());
  for (const MapPoint& point : points) {
    const Eigen::Vector3f& p = point.position;
    cloud.push_back({p.x(), p.y(), p.z(), point.intensity, point.lidar, point.plane});
  }
  WriteCloud(path, cloud);
}

void WriteColouredPointCloudFile(const std::filesystem::path& path,
                                 const std::vector<ColouredPoint>& points) {
  pcl::PointCloud<ColouredPointOfFile> cloud;
  cloud.reserve(points.size());
  for (const ColouredPoint& point : points) {
    const std::uint32_t packed = point.bgr[0] | point.bgr[1] << 8 | point.bgr[2] << 16;
    float rgb = 0.0f;
    std::memcpy(&rgb, &packed, sizeof(rgb));
    const Eigen::Vector3f& p = point.position;
    cloud.push_back({p.x(), p.y(), p.z(), rgb});
  }
  WriteCloud(path, cloud);
}

}  // namespace mlic
