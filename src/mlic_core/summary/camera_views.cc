#include "mlic_core/summary/camera_views.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "mlic_core/problem/landmark_terms.h"

namespace mlic {
namespace {

constexpr double kTrackSeconds = 0.5;  // either side of the view; from: structural, how a picture looks

// The observations of one landmark by one camera in order of time.
using TimedPixels = std::map<double, Eigen::Vector2f>;

// Time of the camera's image that sees the most landmarks; false when it sees none.
bool FindFullestImage(const LandmarkSet& landmarks, int camera, double* time) {
  std::map<double, int> counts;
  for (const LandmarkObservation& o : landmarks.observations) {
    if (o.camera == camera) ++counts[o.time];
  }
  int most = 0;
  for (const auto& [t, count] : counts) {
    if (count <= most) continue;
    most = count;
    *time = t;
  }
  return most > 0;
}

std::vector<LandmarkProjection> ProjectionsAt(const LandmarkSet& landmarks,
                                              const std::vector<Eigen::Vector2d>& residuals, int camera,
                                              double time) {
  std::vector<LandmarkProjection> observations;
  for (std::size_t p = 0; p < landmarks.points.size(); ++p) {
    TimedPixels track;
    std::size_t here = landmarks.observations.size();
    for (std::size_t k = landmarks.begin[p]; k < landmarks.begin[p + 1]; ++k) {
      const LandmarkObservation& o = landmarks.observations[k];
      if (o.camera != camera || std::abs(o.time - time) > kTrackSeconds) continue;
      track[o.time] = o.pixel.cast<float>();
      if (o.time == time) here = k;
    }
    if (here == landmarks.observations.size() || !residuals[here].allFinite()) continue;
    LandmarkProjection observation;
    observation.observed = landmarks.observations[here].pixel.cast<float>();
    observation.projected = (landmarks.observations[here].pixel + residuals[here]).cast<float>();
    for (const auto& [t, pixel] : track) observation.track.push_back(pixel);
    observations.push_back(std::move(observation));
  }
  return observations;
}

}  // namespace

std::vector<LandmarkMark> MarkLandmarks(const LandmarkSet& landmarks, const CalibrationState& state,
                                        const RigidTransform& origin, std::size_t largest) {
  std::vector<LandmarkMark> marks;
  if (landmarks.points.empty()) return marks;
  const std::vector<Eigen::Vector2d> residuals = LandmarkResiduals(landmarks, state, 0);
  const std::size_t stride = (landmarks.points.size() + largest - 1) / largest;
  for (std::size_t p = 0; p < landmarks.points.size(); p += stride) {
    double squares = 0.0;
    int observations = 0;
    for (std::size_t k = landmarks.begin[p]; k < landmarks.begin[p + 1]; ++k) {
      if (!residuals[k].allFinite()) continue;
      squares += residuals[k].squaredNorm();
      ++observations;
    }
    if (observations == 0) continue;
    marks.push_back({(origin * landmarks.points[p].position).cast<float>(),
                     static_cast<float>(std::sqrt(squares / observations)), observations});
  }
  return marks;
}

std::vector<CameraView> ChooseViews(const Rig& rig, const Drive& drive, const CalibrationState& state,
                                    const LandmarkSet& landmarks) {
  std::vector<CameraView> views;
  if (landmarks.points.empty()) return views;
  const std::vector<Eigen::Vector2d> residuals = LandmarkResiduals(landmarks, state, 0);
  for (std::size_t c = 0; c < state.cameras.size() && c < drive.cameras.size(); ++c) {
    double time = 0.0;
    if (drive.cameras[c].images == nullptr || drive.cameras[c].images->Count() == 0) continue;
    if (!FindFullestImage(landmarks, static_cast<int>(c), &time)) continue;
    CameraView view;
    view.camera = rig.cameras[c].name;
    view.images = drive.cameras[c].images;
    view.image = NearestImage(*view.images, time);
    view.observations = ProjectionsAt(landmarks, residuals, static_cast<int>(c), time);
    if (!view.observations.empty()) views.push_back(std::move(view));
  }
  return views;
}

std::vector<CameraKeyframes> UsedKeyframes(const Rig& rig, const Dataset& dataset,
                                           const std::vector<DriveTerms>& drives) {
  std::vector<std::set<TimeNs>> stamps(rig.cameras.size());
  for (std::size_t d = 0; d < drives.size(); ++d) {
    for (const LandmarkObservation& o : drives[d].landmarks.observations) {
      // Observations may be somewhat off the stamps (StampCourse).
      const auto& images = dataset.drives[d].cameras[o.camera].images;
      const double stamp = images == nullptr ? o.time : images->Time(NearestImage(*images, o.time));
      stamps[o.camera].insert(TimeFrom(dataset.drives[d].epoch, stamp));
    }
  }
  std::vector<CameraKeyframes> keyframes;
  for (std::size_t c = 0; c < stamps.size(); ++c) {
    if (stamps[c].empty()) continue;
    keyframes.push_back({rig.cameras[c].name, {stamps[c].begin(), stamps[c].end()}});
  }
  return keyframes;
}

}  // namespace mlic
