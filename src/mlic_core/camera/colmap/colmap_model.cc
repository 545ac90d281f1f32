#include "mlic_core/camera/colmap/colmap_model.h"

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <limits>
#include <map>
#include <string>

#include "mlic_core/camera/colmap/colmap_camera.h"
#include "mlic_core/camera/colmap/colmap_database.h"
#include "mlic_core/common/error.h"

namespace mlic {
namespace {

// Little-endian values in turn. COLMAP's format: src/base/reconstruction.cc, WriteCamerasBinary and so on.
class BinaryFile {
 public:
  explicit BinaryFile(const std::filesystem::path& path) : path_(path), file_(path, std::ios::binary) {}
  template <typename T>
  T Read() {
    T value{};
    if (!file_.read(reinterpret_cast<char*>(&value), sizeof(T))) {
      Fail("is missing or cut off");
    }
    return value;
  }
  [[noreturn]] void Fail(const std::string& what) const {
    throw InputError("COLMAP's model " + path_.string() + ": " + what + "; start again with --fresh");
  }
  void SkipText() {
    while (Read<char>() != '\0') {
    }
  }

 private:
  std::filesystem::path path_;
  std::ifstream file_;
};

CameraIntrinsics ReadCamera(const std::filesystem::path& path) {
  BinaryFile file(path);
  if (file.Read<std::uint64_t>() != 1) throw InputError(path.string() + ": expected one camera");
  file.Read<std::uint32_t>();
  const auto model = static_cast<ColmapModelId>(file.Read<std::int32_t>());
  if (model != ColmapModelId::kOpenCv && model != ColmapModelId::kOpenCvFisheye &&
      model != ColmapModelId::kFullOpenCv) {
    throw InputError(path.string() + ": expected a camera of OPENCV, OPENCV_FISHEYE or FULL_OPENCV");
  }
  const int width = static_cast<int>(file.Read<std::uint64_t>());
  const int height = static_cast<int>(file.Read<std::uint64_t>());
  const int count = model == ColmapModelId::kFullOpenCv ? 12 : 8;
  std::vector<double> parameters;
  for (int i = 0; i < count; ++i) parameters.push_back(file.Read<double>());
  return FromColmapParameters(model, width, height, parameters);
}

// Points in the order of their identities, so that the result does not depend on COLMAP's hash maps.
std::map<std::uint64_t, Eigen::Vector3d> ReadPoints(const std::filesystem::path& path) {
  BinaryFile file(path);
  std::map<std::uint64_t, Eigen::Vector3d> points;
  for (auto left = file.Read<std::uint64_t>(); left > 0; --left) {
    Eigen::Vector3d& point = points[file.Read<std::uint64_t>()];
    for (int k = 0; k < 3; ++k) point[k] = file.Read<double>();
    for (int k = 0; k < 3; ++k) file.Read<std::uint8_t>();
    file.Read<double>();
    for (auto track = file.Read<std::uint64_t>(); track > 0; --track) file.Read<std::uint64_t>();
  }
  return points;
}

ColmapReconstruction::Image ReadImage(BinaryFile& file, const std::map<std::uint64_t, int>& indices) {
  ColmapReconstruction::Image image;
  const auto number = file.Read<std::uint32_t>();
  if (number == 0 || number > std::numeric_limits<std::int32_t>::max())
    file.Fail("an image has no number of ours");
  image.keyframe = static_cast<int>(number - 1);
  Eigen::Quaterniond& q = image.T_camera_world.rotation;
  q.w() = file.Read<double>();
  q.x() = file.Read<double>();
  q.y() = file.Read<double>();
  q.z() = file.Read<double>();
  q.normalize();
  for (int k = 0; k < 3; ++k) image.T_camera_world.translation[k] = file.Read<double>();
  file.Read<std::uint32_t>();
  file.SkipText();
  for (auto left = file.Read<std::uint64_t>(); left > 0; --left) {
    const double x = file.Read<double>(), y = file.Read<double>();
    const auto point = indices.find(file.Read<std::uint64_t>());
    image.pixels.push_back({x - 0.5, y - 0.5});
    image.points.push_back(point == indices.end() ? -1 : point->second);
  }
  return image;
}

}  // namespace

ColmapReconstruction ReadColmapModel(const std::filesystem::path& directory) {
  ColmapReconstruction model;
  model.camera = ReadCamera(directory / "cameras.bin");
  std::map<std::uint64_t, int> indices;
  for (const auto& [id, point] : ReadPoints(directory / "points3D.bin")) {
    indices[id] = static_cast<int>(model.points.size());
    model.points.push_back(point);
  }
  BinaryFile file(directory / "images.bin");
  for (auto left = file.Read<std::uint64_t>(); left > 0; --left)
    model.images.push_back(ReadImage(file, indices));
  std::sort(model.images.begin(), model.images.end(),
            [](const auto& a, const auto& b) { return a.keyframe < b.keyframe; });
  return model;
}

}  // namespace mlic
