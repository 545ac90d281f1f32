#include "mlic_core/uncertainty/stamp_doubt.h"

#include <algorithm>
#include <utility>

#include "mlic_core/problem/layout.h"

namespace mlic {
namespace {

constexpr std::size_t kFewestImages = 20;  // that say something; from: guard

}  // namespace

std::vector<ImageStamps> StampsOfImages(const Adjustment& adjustment) {
  std::vector<ImageStamps> all;
  for (std::size_t d = 0; d < adjustment.problem.drives.size(); ++d) {
    for (std::size_t c = 0; c < adjustment.state.cameras.size(); ++c) {
      if (!adjustment.cameras.found[c] || adjustment.problem.cameras[c].fixed.time_offset) continue;
      ImageStamps images{d, c, {}};
      for (const Keyframe& keyframe : adjustment.cameras.tracks[d].keyframes) {
        if (keyframe.camera == static_cast<int>(c)) images.times.push_back(keyframe.time);
      }
      std::sort(images.times.begin(), images.times.end());
      if (images.times.size() >= kFewestImages) all.push_back(std::move(images));
    }
  }
  return all;
}

std::vector<ImageStamps> OnCourse(std::vector<ImageStamps> all, const AdjustedCameras& cameras) {
  for (ImageStamps& images : all) {
    const StampCourse& course = cameras.stamp_courses[images.drive][images.camera];
    for (double& time : images.times) time += course.At(time);
  }
  return all;
}

std::vector<TrackSet> OnTime(const AdjustedCameras& cameras) {
  std::vector<TrackSet> tracks = cameras.tracks;
  for (std::size_t d = 0; d < cameras.stamp_courses.size(); ++d) {
    for (Keyframe& keyframe : tracks[d].keyframes) {
      keyframe.time += cameras.stamp_courses[d][static_cast<std::size_t>(keyframe.camera)].At(keyframe.time);
    }
  }
  return tracks;
}

Eigen::MatrixXd ScatterOfStamps(const Adjustment& adjustment, double scale) {
  const int calibration = Layout(adjustment.state, adjustment.problem.estimate_imu_matrices).calibration;
  Eigen::MatrixXd scatter = Eigen::MatrixXd::Zero(calibration, calibration);
  if (adjustment.cameras.stamp_courses.empty()) return scatter;
  const auto& courses = adjustment.cameras.stamp_courses;
  std::vector<ImageStamps> images = StampsOfImages(adjustment);
  images.erase(
      std::remove_if(images.begin(), images.end(),
                     [&](const ImageStamps& own) { return courses[own.drive][own.camera].IsEmpty(); }),
      images.end());
  const auto evidence =
      EvidenceOfStamps(adjustment.problem, adjustment.state, OnCourse(images, adjustment.cameras));
  for (std::size_t i = 0; i < evidence.size(); ++i) {
    scatter += ScatterOfCourse(courses[images[i].drive][images[i].camera], evidence[i]) / scale;
  }
  return scatter;
}

}  // namespace mlic
