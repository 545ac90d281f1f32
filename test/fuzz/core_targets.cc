#include "fuzz/core_targets.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <vector>

#include "fuzz/corpus.h"
#include "mlic_core/camera/colmap/colmap_model.h"
#include "mlic_core/io/checkpoint/serialize.h"
#include "mlic_core/io/checkpoint/serialize_stages.h"
#include "mlic_core/io/result/point_cloud_reader.h"
#include "mlic_core/io/result/result_file.h"
#include "mlic_core/io/rig/rig_file.h"
#include "support/files.h"

namespace mlic {
namespace {

namespace fs = std::filesystem;

void Write(const fs::path& path, const std::string& bytes) { std::ofstream(path, std::ios::binary) << bytes; }

// A file that holds the bytes, the same for all calls.
fs::path FileOf(const std::string& bytes) {
  static const TemporaryDirectory directory;
  const fs::path path = directory.Path() / "bytes";
  Write(path, bytes);
  return path;
}

template <typename T>
void ReadStage(const std::string& bytes) {
  T object;
  FromBytes(std::vector<char>(bytes.begin() + 1, bytes.end()), &object);
}

}  // namespace

void FuzzRig(const std::string& bytes) { LoadRigFile(FileOf(bytes)); }
void FuzzResult(const std::string& bytes) { ReadCalibrationFile(FileOf(bytes)); }
void FuzzPointCloud(const std::string& bytes) { ReadPointCloudFile(FileOf(bytes)); }

void FuzzColmap(const std::string& bytes) {
  if (bytes.empty()) return;
  static const std::vector<std::string> names{"cameras.bin", "points3D.bin", "images.bin"};
  static const TemporaryDirectory directory;
  for (const std::string& name : names) Write(directory.Path() / name, CorpusFile("colmap", name).substr(1));
  Write(directory.Path() / names[static_cast<unsigned char>(bytes[0]) % names.size()], bytes.substr(1));
  ReadColmapModel(directory.Path());
}

void FuzzCheckpoint(const std::string& bytes) {
  if (bytes.empty()) return;
  switch (static_cast<unsigned char>(bytes[0]) % 5) {
    case 0:
      return ReadStage<Dataset>(bytes);
    case 1:
      return ReadStage<CalibrationResult>(bytes);
    case 2:
      return ReadStage<Adjustment>(bytes);
    case 3:
      return ReadStage<Initialization>(bytes);
    default:
      return ReadStage<TrackSet>(bytes);
  }
}

}  // namespace mlic
