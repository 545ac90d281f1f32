#pragma once

#include <rosbag/bag.h>

#include <filesystem>
#include <functional>
#include <string>

#include "mlic_sim/simulation.h"

namespace mlic {

// Writes a simulated drive to a bag, each LiDAR's points as its driver lays them out: sensor_msgs/Imu,
// sensor_msgs/PointCloud2 and livox_ros_driver/CustomMsg (no driver package needed). The bag is written
// uncompressed to PATH.part and gets its name in Finish, so that an interrupted run leaves no half-written
// bag.
class DriveBagWriter : public sim::DriveSink {
 public:
  // on_time gets the drive's time (s) now and then, for progress. Throws InputError if the file cannot be
  // opened.
  DriveBagWriter(const std::filesystem::path& path, const sim::SensorSet& sensors,
                 std::function<void(double)> on_time);
  // Without Finish the part that was written is removed.
  ~DriveBagWriter() override;

  void OnImu(const sim::SimulatedImuMessage& message) override;
  void OnScan(sim::SimulatedScan scan) override;
  void Finish();

 private:
  const std::filesystem::path path_, part_path_;
  const sim::SensorSet& sensors_;
  std::function<void(double)> on_time_;
  rosbag::Bag bag_;
  std::uint32_t sequence_ = 0;
  bool finished_ = false;
};

}  // namespace mlic
