#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "mlic_sim/camera_sensor.h"
#include "mlic_sim/surface_textures.h"
#include "mlic_sim/trajectory.h"
#include "mlic_sim/world.h"

namespace mlic::sim {

// Makes the pictures of one camera: rays at twice the image's resolution, filtered down by a kernel of 1 3 3
// 1 in each direction, which is symmetric about the pixel's centre; then the lens (vignetting), the sensor
// (shot and read noise) and gamma. Row v is exposed around time + v / height * readout. Thread-safe; the
// outcome depends on the arguments only.
class CameraRenderer {
 public:
  // All references must outlive the renderer. times: of the drive's images, s, over which an automatic
  // exposure has its mean.
  CameraRenderer(const SimulatedCamera& camera, const World& world, const Lighting& lighting,
                 const SurfaceTextures& textures, const Trajectory& trajectory,
                 const std::vector<double>& times = {});

  // The picture whose row 0 is exposed around `time` (s, IMU clock); where the exposure is automatic, around
  // what its stamp takes for that. CV_8UC1 for mono and Bayer encodings (Bayer: the mosaic), CV_8UC3 (BGR)
  // otherwise. seed: of the noise; without noise the exposure is always the same.
  cv::Mat Render(double time, bool with_noise, std::uint64_t seed) const;

  // Of one picture. middle, length: s; gain: of the sensor.
  struct Exposure {
    double middle, length, gain;
  };
  // Of the picture that Render() makes of the same arguments.
  Exposure ExposureOf(double time, bool with_noise) const;
  // The light before lens and sensor, CV_32FC3, linear red, green, blue, of rows [begin, end).
  cv::Mat RenderLight(const Exposure& exposure, int begin, int end) const;

 private:
  struct RowPose;
  // What an automatic exposure goes by: the mean light of the half second before.
  double MeteredLight(double time) const;
  double AutomaticLength(double light) const;
  std::vector<RowPose> PosesOf(const Exposure& exposure, int sample_row) const;
  void TraceRow(const Exposure& exposure, int sample_row, std::vector<float>& light) const;
  void Shade(const RayPacket& packet, int lane, const MovingObjects::Instant& moving, float pixel_angle,
             float* light) const;
  void Expose(const cv::Mat& light, int row, float gain, bool with_noise, std::uint64_t seed,
              cv::Mat& image) const;

  const SimulatedCamera camera_;
  const World& world_;
  const Lighting lighting_;
  const SurfaceTextures& textures_;
  const Trajectory& trajectory_;
  int columns_;                            // of bearings_: the image and a border of one pixel
  std::vector<Eigen::Vector3f> bearings_;  // of pixel centres, camera frame; NaN where the lens sees nothing
  std::vector<float> vignette_;            // share of light that reaches each pixel
  std::vector<std::uint8_t> gamma_;        // from linear, kGammaSteps to saturation
  double mean_exposure_;                   // s
};

}  // namespace mlic::sim
