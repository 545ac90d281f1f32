#include "mlic_core/evaluation/fresh_matches.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <set>

#include "mlic_core/camera/features/feature_matcher.h"
#include "mlic_core/camera/tracks/image_pairs.h"
#include "mlic_core/camera/two_view/two_view.h"
#include "mlic_core/common/parallel.h"
#include "mlic_core/evaluation/pose_interpolation.h"

namespace mlic {
namespace {

// An image that is not a keyframe.
struct FreshImage {
  std::size_t index = 0;
  TimeNs stamp = 0;
  double time = 0.0;  // IMU clock, s since the epoch
  RigidTransform T_map_camera;
};

struct FreshCamera {
  const SensorResult* sensor = nullptr;
  const CameraRecording* recording = nullptr;
  std::vector<FreshImage> images;
};

// Two cameras and an image of each.
struct ImageMatch {
  std::size_t camera_a, camera_b;
  const FreshImage *a, *b;
};

struct Features {
  FeatureSet set;
  std::vector<Eigen::Vector3d> bearings;
};

FreshCamera FindImages(const Drive& drive, std::size_t camera, const SensorResult& sensor,
                       const std::vector<StampedPose>& trajectory,
                       const std::vector<CameraKeyframes>& keyframes) {
  FreshCamera fresh{&sensor, &drive.cameras[camera], {}};
  std::set<TimeNs> used;
  for (const CameraKeyframes& of_camera : keyframes) {
    if (of_camera.camera == sensor.name) used.insert(of_camera.stamps.begin(), of_camera.stamps.end());
  }
  const ImageSource& images = *fresh.recording->images;
  if (trajectory.empty()) return fresh;
  const double middle = SecondsSince(drive.epoch, MiddleOf(trajectory));
  for (std::size_t i = 0; i < images.Count(); ++i) {
    FreshImage image;
    image.index = i;
    image.stamp = TimeFrom(drive.epoch, images.Time(i));
    image.time = sensor.calibration.OnImuClock(images.Time(i), middle);
    if (used.count(image.stamp) > 0) continue;
    if (PoseOfRow(sensor, trajectory, image.stamp, 0.5 * sensor.intrinsics->height, &image.T_map_camera)) {
      fresh.images.push_back(image);
    }
  }
  return fresh;
}

// Pairs of images of two cameras at nearly the same time with a common view, spread evenly.
std::vector<ImageMatch> ChooseImagePairs(const std::vector<FreshCamera>& cameras, std::size_t a,
                                         std::size_t b, const FreshMatchOptions& options) {
  const std::vector<double> depths{options.nearest, std::sqrt(options.nearest * options.farthest),
                                   options.farthest};
  std::vector<ImageMatch> candidates;
  const std::vector<FreshImage>& others = cameras[b].images;
  for (const FreshImage& image : cameras[a].images) {
    auto other = std::lower_bound(others.begin(), others.end(), image.time,
                                  [](const FreshImage& i, double time) { return i.time < time; });
    if (other == others.end() ||
        (other != others.begin() && image.time - std::prev(other)->time < other->time - image.time)) {
      if (other == others.begin()) continue;
      --other;
    }
    if (std::abs(other->time - image.time) > options.largest_time_apart) continue;
    const double baseline = (other->T_map_camera.translation - image.T_map_camera.translation).norm();
    if (baseline < options.least_baseline) continue;
    const PredictedView view_a{image.T_map_camera, &*cameras[a].sensor->intrinsics};
    const PredictedView view_b{other->T_map_camera, &*cameras[b].sensor->intrinsics};
    // from: derivation, as largest_view_angle of image_pairs.h.
    constexpr double kLargestViewAngle = 0.6;  // rad, as where tracks are made
    if (SharedView(view_a, view_b, depths, kLargestViewAngle) < options.least_overlap) continue;
    candidates.push_back({a, b, &image, &*other});
  }
  std::vector<ImageMatch> chosen;
  const std::size_t wanted = std::min<std::size_t>(candidates.size(), options.image_pairs);
  for (std::size_t k = 0; k < wanted; ++k) {
    chosen.push_back(candidates[(2 * k + 1) * candidates.size() / (2 * wanted)]);
  }
  return chosen;
}

Features Detect(const FreshCamera& camera, const FreshImage& image, const FeatureMatcher& matcher) {
  cv::Mat gray = camera.recording->images->Load(image.index);
  if (gray.channels() == 3) cv::cvtColor(gray, gray, cv::COLOR_BGR2GRAY);
  Features features{matcher.Detect(gray, camera.recording->mask), {}};
  for (const Eigen::Vector2f& pixel : features.set.pixels) {
    Eigen::Vector3d bearing;
    const bool covered = Unproject(*camera.sensor->intrinsics, pixel.cast<double>(), &bearing);
    features.bearings.push_back(covered ? bearing : Eigen::Vector3d(Eigen::Vector3d::Zero()));
  }
  return features;
}

std::vector<FreshMatch> Match(const std::vector<FreshCamera>& cameras, const ImageMatch& pair,
                              const Features& a, const Features& b, const FeatureMatcher& matcher,
                              const FreshMatchOptions& options) {
  const SensorResult &camera_a = *cameras[pair.camera_a].sensor, &camera_b = *cameras[pair.camera_b].sensor;
  const RigidTransform T_b_a = pair.b->T_map_camera.Inverse() * pair.a->T_map_camera;
  MatchGuide guide;
  guide.R_b_a = T_b_a.rotation.toRotationMatrix();
  guide.t_b_a = T_b_a.translation.normalized();
  guide.largest_error = options.search_error;
  guide.bearings_a = &a.bearings;
  guide.bearings_b = &b.bearings;
  const std::vector<FeatureMatch> matches = matcher.Match(a.set, b.set, &guide);
  std::vector<Eigen::Vector3d> bearings_a, bearings_b;
  for (const FeatureMatch& match : matches) {
    bearings_a.push_back(a.bearings[match.a]);
    bearings_b.push_back(b.bearings[match.b]);
  }
  TwoViewOptions two_view;
  two_view.fewest_inliers = options.fewest_matches;
  two_view.largest_error = options.largest_disagreement /
                           std::min(camera_a.intrinsics->parameters[0], camera_b.intrinsics->parameters[0]);
  const auto geometry = EstimateTwoView(bearings_a, bearings_b, two_view);
  std::vector<FreshMatch> fresh;
  for (std::size_t k = 0; geometry && k < matches.size(); ++k) {
    if (!geometry->inlier[k]) continue;
    fresh.push_back({camera_a.name, camera_b.name, pair.a->stamp, pair.b->stamp,
                     a.set.pixels[matches[k].a].cast<double>(), b.set.pixels[matches[k].b].cast<double>()});
  }
  return fresh;
}

}  // namespace

const SensorResult* FindCamera(const CalibrationResult& calibration, const std::string& name) {
  for (const SensorResult& sensor : calibration.sensors) {
    if (sensor.name == name && sensor.intrinsics) return &sensor;
  }
  return nullptr;
}

bool PoseOfRow(const SensorResult& camera, const std::vector<StampedPose>& trajectory, TimeNs stamp,
               double row, RigidTransform* T_map_camera) {
  const double readout = camera.rolling_shutter_readout.value_or(0.0);
  if (trajectory.empty()) return false;
  const double offset = camera.calibration.OffsetAt(SecondsSince(MiddleOf(trajectory), stamp));
  const TimeNs time = TimeFrom(stamp, offset + row / camera.intrinsics->height * readout);
  std::size_t hint = 0;
  RigidTransform T_map_imu;
  if (!InterpolatePose(trajectory, time, &hint, &T_map_imu)) return false;
  *T_map_camera = T_map_imu * camera.calibration.T_imu_sensor;
  return true;
}

std::vector<FreshMatch> FindFreshMatches(const Drive& drive, const std::vector<std::string>& names,
                                         const CalibrationResult& calibration,
                                         const std::vector<StampedPose>& trajectory,
                                         const std::vector<CameraKeyframes>& keyframes,
                                         const FreshMatchOptions& options,
                                         const CancellationToken& cancellation) {
  std::vector<FreshCamera> cameras;
  for (std::size_t c = 0; c < names.size() && c < drive.cameras.size(); ++c) {
    const SensorResult* sensor = FindCamera(calibration, names[c]);
    if (sensor == nullptr || drive.cameras[c].images == nullptr) continue;
    cameras.push_back(FindImages(drive, c, *sensor, trajectory, keyframes));
  }
  std::vector<ImageMatch> pairs;
  for (std::size_t a = 0; a < cameras.size(); ++a) {
    for (std::size_t b = a + 1; b < cameras.size(); ++b) {
      const std::vector<ImageMatch> chosen = ChooseImagePairs(cameras, a, b, options);
      pairs.insert(pairs.end(), chosen.begin(), chosen.end());
    }
  }
  std::map<const FreshImage*, std::size_t> place;  // of each image that takes part
  std::vector<std::pair<std::size_t, const FreshImage*>> images;
  for (const ImageMatch& pair : pairs) {
    for (const auto& [camera, image] : {std::pair(pair.camera_a, pair.a), std::pair(pair.camera_b, pair.b)}) {
      if (place.emplace(image, images.size()).second) images.emplace_back(camera, image);
    }
  }
  const std::unique_ptr<FeatureMatcher> matcher = MakeClassicalMatcher();
  std::vector<Features> features(images.size());
  ParallelFor(images.size(), [&](std::size_t i) {
    cancellation.ThrowIfCancelled();
    features[i] = Detect(cameras[images[i].first], *images[i].second, *matcher);
  });
  std::vector<std::vector<FreshMatch>> found(pairs.size());
  ParallelFor(pairs.size(), [&](std::size_t k) {
    cancellation.ThrowIfCancelled();
    found[k] = Match(cameras, pairs[k], features[place.at(pairs[k].a)], features[place.at(pairs[k].b)],
                     *matcher, options);
  });
  std::vector<FreshMatch> matches;
  for (const std::vector<FreshMatch>& of_pair : found) {
    matches.insert(matches.end(), of_pair.begin(), of_pair.end());
  }
  return matches;
}

}  // namespace mlic
