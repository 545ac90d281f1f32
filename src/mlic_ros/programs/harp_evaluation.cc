#include "mlic_ros/programs/harp_evaluation.h"

#include <algorithm>
#include <cctype>
#include <opencv2/imgcodecs.hpp>
#include <set>

#include "mlic_core/common/error.h"
#include "mlic_core/common/join.h"
#include "mlic_core/evaluation/fresh_matches.h"

namespace mlic {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> PhotosIn(const fs::path& folder) {
  if (!fs::is_directory(folder)) throw InputError("--harp " + folder.string() + ": no such folder");
  const std::set<std::string> endings = {".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff"};
  std::vector<fs::path> photos;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    std::string ending = entry.path().extension().string();
    std::transform(ending.begin(), ending.end(), ending.begin(),
                   [](unsigned char c) { return std::tolower(c); });
    if (endings.count(ending) > 0) photos.push_back(entry.path());
  }
  if (photos.empty()) {
    throw InputError("--harp " + folder.string() + ": holds no photo (png, jpg, bmp, tif)");
  }
  std::sort(photos.begin(), photos.end());
  return photos;
}

cv::Mat LoadPhoto(const fs::path& path, const CameraIntrinsics& intrinsics) {
  // As the sensor lies: calibrations are of messages, which no one turns upright.
  const cv::Mat photo = cv::imread(path.string(), cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION);
  if (photo.empty()) throw InputError(path.string() + ": cannot be read as an image");
  if (photo.cols != intrinsics.width || photo.rows != intrinsics.height) {
    throw InputError(path.string() + ": is " + std::to_string(photo.cols) + " x " +
                     std::to_string(photo.rows) + " px, but the calibration is of " +
                     std::to_string(intrinsics.width) + " x " + std::to_string(intrinsics.height) +
                     " px; give photos as the camera writes them");
  }
  return photo;
}

const SensorResult& CameraOf(const CalibrationResult& calibration, const std::string& name) {
  std::vector<std::string> names;
  for (const SensorResult& sensor : calibration.sensors) {
    if (sensor.intrinsics) names.push_back(sensor.name);
  }
  const SensorResult* found = FindCamera(calibration, name.empty() && names.size() == 1 ? names[0] : name);
  if (found != nullptr) return *found;
  const std::string cameras = names.empty() ? "none" : Joined(names);
  throw InputError((name.empty() ? "--camera: which camera took the photos?"
                                 : "--camera " + name + ": not in the calibration.") +
                   " Cameras with intrinsics: " + cameras);
}

}  // namespace

HarpEvaluation MeasurePhotos(const fs::path& folder, const std::string& name,
                             const CalibrationResult& calibration,
                             const std::optional<CalibrationResult>& truth) {
  const SensorResult& camera = CameraOf(calibration, name);
  const std::vector<fs::path> photos = PhotosIn(folder);
  std::vector<std::string> names;
  for (const fs::path& photo : photos) names.push_back(photo.filename().string());
  std::vector<std::vector<HarpEdge>> edges(photos.size());
  LitPart lit;
  for (const fs::path& photo : photos) lit.Add(LoadPhoto(photo, *camera.intrinsics));
  const cv::Mat mask = lit.Mask();
  for (std::size_t k = 0; k < photos.size(); ++k) {
    edges[k] = FindHarpEdges(LoadPhoto(photos[k], *camera.intrinsics), mask);
  }
  HarpEvaluation evaluation;
  evaluation.camera = camera.name;
  evaluation.columns.push_back({"calibration", MeasureHarp(names, edges, *camera.intrinsics)});
  if (truth) {
    evaluation.columns.push_back(
        {"truth", MeasureHarp(names, edges, *CameraOf(*truth, camera.name).intrinsics)});
  }
  const HarpMeasurement& measurement = evaluation.columns.front().measurement;
  const auto worst =
      std::max_element(measurement.photos.begin(), measurement.photos.end(),
                       [](const HarpPhoto& a, const HarpPhoto& b) { return a.errors.rms < b.errors.rms; });
  const auto index = static_cast<std::size_t>(worst - measurement.photos.begin());
  evaluation.picture = DrawHarp(LoadPhoto(photos[index], *camera.intrinsics), *worst, measurement);
  return evaluation;
}

}  // namespace mlic
