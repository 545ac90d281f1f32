#pragma once

#include <memory>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "mlic_sim/camera_renderer.h"

namespace mlic::sim {

// A calibration harp (Tang et al., "High-precision camera distortion measurements with a calibration harp",
// JOSA A 2012): straight bars, bright on dark, and photos of them by one camera that stands still in several
// poses, so that every part of its image sees edges along both of its axes. What bends them there is its
// lens. Map frame: x across the bars, z along them, y away from the camera; the bars lie in y = 0.
class Harp {
 public:
  explicit Harp(const SimulatedCamera& camera);
  ~Harp();

  std::size_t PhotoCount() const { return poses_.size(); }
  // T_map_camera of a photo.
  const RigidTransform& Pose(std::size_t photo) const { return poses_[photo]; }
  // Photo as a loader gives it, CV_8UC1 or CV_8UC3. seed: of the noise. Thread-safe.
  cv::Mat Render(std::size_t photo, bool with_noise, std::uint64_t seed) const;

  // The bars' edges: x of each, in order, and how far they reach up and down, m.
  const std::vector<double>& edges() const { return edges_; }
  double half_length() const { return edges_.back(); }

 private:
  class Standing;

  SimulatedCamera camera_;
  std::vector<RigidTransform> poses_;
  std::vector<double> edges_;
  Lighting lighting_;
  std::unique_ptr<World> world_;
  std::unique_ptr<SurfaceTextures> textures_;
  std::unique_ptr<Trajectory> standing_;
  std::unique_ptr<CameraRenderer> renderer_;
};

}  // namespace mlic::sim
