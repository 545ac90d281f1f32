#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace mlic {

// One image that features are taken from. time: stamp on the camera's own clock, s since the drive's epoch.
struct Keyframe {
  int camera = 0;         // of Drive::cameras
  std::size_t image = 0;  // of the camera's ImageSource
  double time = 0.0;
};

// Where one keyframe sees the point of a track. sigma: px, of each coordinate of the pixel.
struct TrackObservation {
  std::int32_t keyframe = 0;
  Eigen::Vector2f pixel = Eigen::Vector2f::Zero();
  float sigma = 0.5f;
};

// One fixed point of the world as several keyframes see it, each at most once. Ordered by keyframe.
struct Track {
  std::vector<TrackObservation> observations;
};

// Keyframes ordered by camera, then time.
struct TrackSet {
  std::vector<Keyframe> keyframes;
  std::vector<Track> tracks;
};

}  // namespace mlic
