#include "mlic_sim/image_stage.h"

#include <opencv2/imgproc.hpp>
#include <utility>

#include "mlic_core/common/random.h"
#include "mlic_sim/surroundings.h"

namespace mlic::sim {
namespace {

class RenderedImages : public ImageSource {
 public:
  RenderedImages(std::shared_ptr<const ImageStage> stage, std::size_t camera, double duration)
      : stage_(std::move(stage)),
        camera_(camera),
        times_(ImageTimes(stage_->camera(camera), duration)),
        middle_(0.5 * duration) {}

  std::size_t Count() const override { return times_.size(); }
  double Time(std::size_t index) const override {
    return stage_->camera(camera_).calibration.OnOwnClock(times_.at(index), middle_);
  }
  cv::Mat Load(std::size_t index) const override {
    return WithoutMosaic(stage_->camera(camera_), stage_->Render(camera_, index, times_.at(index)));
  }

 private:
  std::shared_ptr<const ImageStage> stage_;
  std::size_t camera_;
  std::vector<double> times_;
  double middle_;  // s, of the drive
};

std::unique_ptr<Trajectory> MotionOn(const MotionGround& ground, const SensorSet& sensors,
                                     const SimulationOptions& options) {
  if (options.recorded) return MakeRecordedTrajectory(options.recorded->path);
  return MakeTrajectory(options.scenario, options.seed, options.duration, sensors.imu.T_body_imu, ground);
}

}  // namespace

std::unique_ptr<Trajectory> MakeTrajectory(const SensorSet& sensors, const SimulationOptions& options) {
  return MotionOn(MakeSurroundings(options.world, options.world_seed, options.scenario).ground, sensors,
                  options);
}

ImageStage::ImageStage(const SensorSet& sensors, const SimulationOptions& options)
    : ImageStage(sensors, options, MakeSurroundings(options.world, options.world_seed, options.scenario)) {}

ImageStage::ImageStage(const SensorSet& sensors, const SimulationOptions& options, Surroundings surroundings)
    : options_(options),
      world_(std::make_unique<World>(
          std::move(surroundings.mesh), sensors.infrared,
          MovingObjects(surroundings.lanes, options.moving_objects, Random(options.seed).Fork(6)))),
      trajectory_(MotionOn(surroundings.ground, sensors, options)),
      cameras_(sensors.cameras) {
  if (cameras_.empty()) return;
  const Lighting& lighting = surroundings.lighting;
  textures_ = std::make_unique<SurfaceTextures>(*world_, lighting);
  for (const SimulatedCamera& camera : cameras_) {
    renderers_.push_back(std::make_unique<CameraRenderer>(camera, *world_, lighting, *textures_, *trajectory_,
                                                          ImageTimes(camera, options.duration)));
  }
}

cv::Mat ImageStage::Render(std::size_t camera, std::size_t index, double time) const {
  const std::uint64_t seed = Random(options_.seed).Fork(4).Fork(camera).Fork(index).Next();
  return renderers_[camera]->Render(time, options_.with_noise, seed);
}

std::vector<double> ImageTimes(const SimulatedCamera& camera, double duration) {
  std::vector<double> times;
  for (std::int64_t k = 0;; ++k) {
    const double time = 0.5 * camera.exposure + camera.phase + static_cast<double>(k) / camera.rate;
    if (time + camera.readout + 0.5 * camera.exposure > duration + 1e-9) return times;
    times.push_back(time);
  }
}

cv::Mat WithoutMosaic(const SimulatedCamera& camera, const cv::Mat& pixels) {
  if (camera.encoding != ImageEncoding::kBayerRggb8) return pixels;
  cv::Mat color;
  cv::cvtColor(pixels, color, cv::COLOR_BayerBG2BGR);  // OpenCV names the pattern by its second row
  return color;
}

std::shared_ptr<const ImageSource> MakeRenderedImages(std::shared_ptr<const ImageStage> stage,
                                                      std::size_t camera, double duration) {
  return std::make_shared<RenderedImages>(std::move(stage), camera, duration);
}

}  // namespace mlic::sim
