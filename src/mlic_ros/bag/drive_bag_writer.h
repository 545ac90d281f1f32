#pragma once

#include <rosbag/bag.h>

#include <filesystem>
#include <functional>
#include <string>

#include "mlic_sim/simulation.h"

namespace mlic {

// Writes a simulated drive to a bag, each LiDAR's points as its driver lays them out: sensor_msgs/Imu,
// sensor_msgs/PointCloud2 and livox_ros_driver/CustomMsg (no driver package needed); sensor_msgs/Image or
// CompressedImage, and CameraInfo. The bag is written
// uncompressed to PATH.part and gets its name in Finish, so that an interrupted run leaves no half-written
// bag.
class DriveBagWriter : public sim::DriveSink {
 public:
  // Gets the drive's time (s) and the number of images so far, now and then.
  using Progress = std::function<void(double time, int images)>;

  // on_progress may be empty. Throws InputError if the file cannot be
  // opened.
  DriveBagWriter(const std::filesystem::path& path, const sim::SensorSet& sensors, Progress on_progress);
  // Without Finish the part that was written is removed.
  ~DriveBagWriter() override;

  void OnImu(const sim::SimulatedImuMessage& message) override;
  void OnScan(sim::SimulatedScan scan) override;
  void OnImage(sim::SimulatedImage image) override;
  void Finish();

 private:
  const std::filesystem::path path_, part_path_;
  const sim::SensorSet& sensors_;
  Progress on_progress_;
  int images_ = 0;
  rosbag::Bag bag_;
  std::uint32_t sequence_ = 0;
  bool finished_ = false;
};

}  // namespace mlic
