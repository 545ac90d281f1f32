#pragma once

#include <memory>
#include <vector>

#include "mlic_core/sensors/images.h"
#include "mlic_sim/camera_renderer.h"
#include "mlic_sim/sensor_set.h"
#include "mlic_sim/simulation_options.h"
#include "mlic_sim/trajectory.h"
#include "mlic_sim/world.h"

namespace mlic::sim {

// The motion of a drive.
std::unique_ptr<Trajectory> MakeTrajectory(const SensorSet& sensors, const SimulationOptions& options);

// The world, the motion and the cameras of one drive: all that a picture needs. Thread-safe.
class ImageStage {
 public:
  ImageStage(const SensorSet& sensors, const SimulationOptions& options);

  const World& world() const { return *world_; }
  const Trajectory& trajectory() const { return *trajectory_; }
  const SimulatedCamera& camera(std::size_t index) const { return cameras_[index]; }

  // Image `index` of a camera, row 0 exposed around `time` (s, IMU clock).
  cv::Mat Render(std::size_t camera, std::size_t index, double time) const;

 private:
  ImageStage(const SensorSet& sensors, const SimulationOptions& options, Surroundings surroundings);

  SimulationOptions options_;
  std::unique_ptr<World> world_;
  std::unique_ptr<Trajectory> trajectory_;
  std::unique_ptr<SurfaceTextures> textures_;  // only where there are cameras
  std::vector<SimulatedCamera> cameras_;
  std::vector<std::unique_ptr<CameraRenderer>> renderers_;
};

// When row 0 of each image of a drive is exposed (middle of the exposure), s, IMU clock; all rows lie within
// the drive.
std::vector<double> ImageTimes(const SimulatedCamera& camera, double duration);

// A picture of CameraRenderer as a loader gives it: CV_8UC3 (BGR) where it is a Bayer mosaic.
cv::Mat WithoutMosaic(const SimulatedCamera& camera, const cv::Mat& pixels);

// The images of one camera, rendered when asked for. Bayer images are interpolated as a loader does it;
// JPEG's own losses are left out. Keeps the stage alive.
std::shared_ptr<const ImageSource> MakeRenderedImages(std::shared_ptr<const ImageStage> stage,
                                                      std::size_t camera, double duration);

}  // namespace mlic::sim
