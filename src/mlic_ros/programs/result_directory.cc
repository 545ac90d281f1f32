#include "mlic_ros/programs/result_directory.h"

#include "mlic_core/common/error.h"

namespace mlic {
namespace {

namespace fs = std::filesystem;

// Removes the directory however the scope is left.
struct Remover {
  fs::path path;
  ~Remover() {
    std::error_code ignored;
    fs::remove_all(path, ignored);
  }
};

}  // namespace

void ReplaceResults(const fs::path& directory, const std::function<void(const fs::path&)>& write) {
  const Remover partial{directory / ".partial"};
  try {
    fs::remove_all(partial.path);
    fs::create_directories(partial.path);
    write(partial.path);
    for (const char* name : {"calibration.yaml", "static_transforms.launch", "sensors.urdf.xacro",
                             "camera_info", "kalibr_camchain.yaml", "trajectory.tum", "map.pcd",
                             "report.html", "images", "initial_calibration.yaml"}) {
      fs::remove_all(directory / name);
    }
    for (const fs::directory_entry& entry : fs::directory_iterator(partial.path)) {
      fs::rename(entry.path(), directory / entry.path().filename());
    }
  } catch (const fs::filesystem_error& error) {
    throw InputError("output directory " + directory.string() + ": " + error.code().message() +
                     "; free space or choose another with --output");
  }
}

}  // namespace mlic
