#include "mlic_core/evaluation/map_colours.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mlic_core/common/parallel.h"
#include "mlic_core/evaluation/fresh_matches.h"
#include "mlic_core/evaluation/photo_pose.h"

namespace mlic {
namespace {

// Constants of this file, from: structural, how a picture looks.

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kCell = 3;           // px of a photo, of the map of what is nearest
constexpr double kBehind = 0.04;   // share of the distance, and
constexpr double kBehindBy = 0.1;  // m, by which a point may lie behind what is nearest and is seen yet
constexpr std::size_t kChunks = 64;

// Where a photo sees the points of a map.
struct Sighting {
  Vector2d pixel;
  float distance = 0.0f;  // m; 0: not seen
};

// The distance of what is nearest, by cells of the photo.
class NearestSurface {
 public:
  explicit NearestSurface(const CameraIntrinsics& intrinsics)
      : columns_(intrinsics.width / kCell + 1),
        rows_(intrinsics.height / kCell + 1),
        focal_length_(intrinsics.parameters[0] / kCell),
        distance_(static_cast<std::size_t>(columns_ * rows_), std::numeric_limits<float>::infinity()) {}

  void Add(const Sighting& point, double size) {
    const int reach = static_cast<int>(std::lround(0.5 * size * focal_length_ / point.distance));
    const int column = ColumnOf(point), row = RowOf(point);
    for (int y = std::max(0, row - reach); y <= std::min(rows_ - 1, row + reach); ++y) {
      for (int x = std::max(0, column - reach); x <= std::min(columns_ - 1, column + reach); ++x) {
        float& distance = distance_[static_cast<std::size_t>(y * columns_ + x)];
        distance = std::min(distance, point.distance);
      }
    }
  }

  bool Hides(const Sighting& point) const {
    const float nearest = distance_[static_cast<std::size_t>(RowOf(point) * columns_ + ColumnOf(point))];
    return point.distance > (1.0 + kBehind) * nearest + kBehindBy;
  }

 private:
  int ColumnOf(const Sighting& point) const { return static_cast<int>(point.pixel.x()) / kCell; }
  int RowOf(const Sighting& point) const { return static_cast<int>(point.pixel.y()) / kCell; }

  int columns_, rows_;
  double focal_length_;  // in cells
  std::vector<float> distance_;
};

struct ColourSum {
  Eigen::Vector3f bgr = Eigen::Vector3f::Zero();
  float weight = 0.0f;
};

Eigen::Vector3f ColourAt(const cv::Mat& photo, const Vector2d& pixel) {
  const int u = static_cast<int>(std::lround(pixel.x())), v = static_cast<int>(std::lround(pixel.y()));
  if (photo.channels() == 1) return Eigen::Vector3f::Constant(photo.at<std::uint8_t>(v, u));
  const auto& bgr = photo.at<cv::Vec3b>(v, u);
  return {static_cast<float>(bgr[0]), static_cast<float>(bgr[1]), static_cast<float>(bgr[2])};
}

void AddPhoto(const std::vector<MapPoint>& map, const cv::Mat& photo, const cv::Mat& mask,
              const PhotoPose& pose, const MapColourOptions& options, std::vector<ColourSum>* sums) {
  std::vector<Sighting> sightings(map.size());
  ParallelChunks(map.size(), kChunks, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      double distance = 0.0;
      const Vector3d place = map[i].position.cast<double>();
      if ((place - pose.Centre()).squaredNorm() > options.farthest * options.farthest) continue;
      if (pose.See(place, &sightings[i].pixel, &distance)) {
        sightings[i].distance = static_cast<float>(distance);
      }
    }
  });
  NearestSurface nearest(pose.intrinsics());
  for (const Sighting& point : sightings) {
    if (point.distance > 0.0f) nearest.Add(point, options.point_size);
  }
  for (std::size_t i = 0; i < map.size(); ++i) {
    const Sighting& point = sightings[i];
    if (!(point.distance > 0.0f) || nearest.Hides(point)) continue;
    const cv::Point pixel(static_cast<int>(std::lround(point.pixel.x())),
                          static_cast<int>(std::lround(point.pixel.y())));
    if (!mask.empty() && mask.at<std::uint8_t>(pixel) == 0) continue;
    const auto weight = static_cast<float>(pose.WeightOf(point.pixel, point.distance));
    (*sums)[i].bgr += weight * ColourAt(photo, point.pixel);
    (*sums)[i].weight += weight;
  }
}

}  // namespace

std::vector<ColouredPoint> ColourMap(const std::vector<MapPoint>& map, const Drive& drive,
                                     const std::vector<std::string>& names,
                                     const CalibrationResult& calibration,
                                     const std::vector<StampedPose>& trajectory,
                                     const MapColourOptions& options, const CancellationToken& cancellation) {
  std::vector<ColourSum> sums(map.size());
  for (std::size_t c = 0; c < names.size() && c < drive.cameras.size(); ++c) {
    const SensorResult* camera = FindCamera(calibration, names[c]);
    const CameraRecording& recording = drive.cameras[c];
    if (camera == nullptr || recording.images == nullptr) continue;
    const std::size_t count = recording.images->Count(), photos = std::min(options.photos, count);
    for (std::size_t k = 0; k < photos; ++k) {
      cancellation.ThrowIfCancelled();
      const std::size_t image = (2 * k + 1) * count / (2 * photos);
      const std::optional<PhotoPose> pose =
          PhotoPose::Of(*camera, trajectory, TimeFrom(drive.epoch, recording.images->Time(image)));
      if (pose) AddPhoto(map, recording.images->Load(image), recording.mask, *pose, options, &sums);
    }
  }
  std::vector<ColouredPoint> coloured;
  for (std::size_t i = 0; i < map.size(); ++i) {
    if (!(sums[i].weight > 0.0f)) continue;
    const Eigen::Vector3f bgr = sums[i].bgr / sums[i].weight;
    ColouredPoint point;
    point.position = map[i].position;
    for (int channel = 0; channel < 3; ++channel) {
      point.bgr[static_cast<std::size_t>(channel)] =
          static_cast<std::uint8_t>(std::clamp(std::lround(bgr[channel]), 0L, 255L));
    }
    coloured.push_back(point);
  }
  return coloured;
}

}  // namespace mlic
