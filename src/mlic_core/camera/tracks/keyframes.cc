#include "mlic_core/camera/tracks/keyframes.h"

#include <algorithm>

#include "mlic_core/camera/features/image_quality.h"
#include "mlic_core/common/parallel.h"
#include "mlic_core/geometry/so3.h"

namespace mlic {
namespace {

// Length of the way up to each image, in radians of apparent motion; without poses, in time.
std::vector<double> MotionAlong(const ImageSource& images, const VehiclePose& pose, double scene_depth) {
  std::vector<double> length(images.Count(), 0.0);
  std::optional<RigidTransform> last;
  for (std::size_t i = 0; i < images.Count(); ++i) {
    if (i > 0) length[i] = length[i - 1];
    if (!pose) {
      length[i] = images.Time(i) - images.Time(0);
      continue;
    }
    const std::optional<RigidTransform> now = pose(images.Time(i));
    if (now && last) {
      length[i] += AngleBetween(last->rotation, now->rotation) +
                   (now->translation - last->translation).norm() / scene_depth;
    }
    if (now) last = now;
  }
  return length;
}

// Of a drive of that many seconds, spread by motion: a longer one has more, so that neighbours see the same.
double MostOf(const KeyframeOptions& options, double seconds) {
  constexpr double kMinute = 60.0;  // s; from: definition
  return options.most_keyframes * std::max(1.0, seconds / kMinute);
}

// For each wanted place along the way, the images to choose from.
std::vector<std::vector<std::size_t>> Candidates(const ImageSource& images, const std::vector<double>& length,
                                                 double spacing, const KeyframeOptions& options) {
  std::vector<std::vector<std::size_t>> places;
  double next = 0.0, last_time = -1e300;
  for (std::size_t i = 0; i < length.size(); ++i) {
    if (length[i] < next || images.Time(i) - last_time < options.least_interval) continue;
    std::vector<std::size_t> place;
    // No nearer than a third of the way to the next place, or neighbouring places would choose the same
    // image.
    for (std::size_t j = i; j < length.size() && static_cast<int>(place.size()) < options.candidates; ++j) {
      if (j > i && (length[j] - length[i] > spacing / 3.0)) break;
      place.push_back(j);
    }
    places.push_back(std::move(place));
    next = length[i] + spacing;
    last_time = images.Time(i);
  }
  return places;
}

}  // namespace

double MostKeyframes(double seconds, bool with_poses) {
  const KeyframeOptions options;
  const double most = MostOf(options, seconds);
  return with_poses ? most : std::max(most, seconds / options.largest_interval);
}

std::vector<Keyframe> SelectKeyframes(const CameraRecording& recording, int camera, const VehiclePose& pose,
                                      const KeyframeOptions& options, const CancellationToken* cancellation) {
  const ImageSource& images = *recording.images;
  if (images.Count() == 0) return {};
  const std::vector<double> length = MotionAlong(images, pose, options.scene_depth);
  const double least = pose ? options.least_motion : options.least_interval;
  const double most = MostOf(options, images.Time(images.Count() - 1) - images.Time(0));
  double spacing = std::max(least, length.back() / std::max(1.0, most - 1.0));
  if (!pose) spacing = std::min(spacing, options.largest_interval);
  const auto places = Candidates(images, length, 0.999 * spacing, options);

  std::vector<std::optional<std::size_t>> chosen(places.size());
  ParallelFor(places.size(), [&](std::size_t p) {
    double best = -1.0;
    for (const std::size_t i : places[p]) {
      if (cancellation != nullptr) cancellation->ThrowIfCancelled();
      const ImageQuality quality = MeasureImageQuality(ToGray(images.Load(i)), recording.mask);
      if (!quality.IsExposed() || quality.sharpness <= best) continue;
      best = quality.sharpness;
      chosen[p] = i;
    }
  });
  std::vector<Keyframe> keyframes;
  for (const auto& image : chosen) {
    if (!image || (!keyframes.empty() && keyframes.back().image >= *image)) continue;
    keyframes.push_back({camera, *image, images.Time(*image)});
  }
  return keyframes;
}

}  // namespace mlic
