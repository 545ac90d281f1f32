#include "mlic_ros/bag/drive_bag_writer.h"

#include <sensor_msgs/Imu.h>

#include <system_error>
#include <utility>

#include "mlic_core/common/error.h"
#include "mlic_ros/bag/camera_messages.h"
#include "mlic_ros/bag/driver_messages.h"

namespace mlic {
namespace {

ros::Time ToRos(TimeNs time) {
  ros::Time stamp;
  stamp.fromNSec(static_cast<std::uint64_t>(time));
  return stamp;
}

}  // namespace

DriveBagWriter::DriveBagWriter(const std::filesystem::path& path, const sim::SensorSet& sensors,
                               Progress on_progress)
    : path_(path),
      part_path_(path.string() + ".part"),
      sensors_(sensors),
      on_progress_(std::move(on_progress)) {
  try {
    bag_.open(part_path_.string(), rosbag::bagmode::Write);
  } catch (const rosbag::BagException& error) {
    throw InputError(path.string() + ": cannot be written: " + error.what());
  }
}

DriveBagWriter::~DriveBagWriter() {
  if (finished_) return;
  try {
    bag_.close();
  } catch (const rosbag::BagException&) {
    // The part is removed in any case.
  }
  std::error_code ignored;
  std::filesystem::remove(part_path_, ignored);
}

void DriveBagWriter::OnImu(const sim::SimulatedImuMessage& message) {
  sensor_msgs::Imu imu;
  imu.header.seq = sequence_++;
  imu.header.stamp = ToRos(message.stamp);
  imu.header.frame_id = sensors_.imu.frame_id;
  imu.orientation_covariance[0] = -1.0;  // no orientation
  imu.angular_velocity.x = message.sample.angular_velocity.x();
  imu.angular_velocity.y = message.sample.angular_velocity.y();
  imu.angular_velocity.z = message.sample.angular_velocity.z();
  imu.linear_acceleration.x = message.sample.specific_force.x();
  imu.linear_acceleration.y = message.sample.specific_force.y();
  imu.linear_acceleration.z = message.sample.specific_force.z();
  bag_.write(sensors_.imu.topic, ToRos(message.received), imu);
}

void DriveBagWriter::OnScan(sim::SimulatedScan scan) {
  const sim::SimulatedLidar& lidar = sensors_.lidars[scan.lidar];
  const ros::Time received = ToRos(scan.received);
  if (lidar.layout == sim::PointLayout::kLivox) {
    bag_.write(lidar.topic, received, MakeLivoxMessage(lidar, scan));
  } else {
    bag_.write(lidar.topic, received, MakePointCloud(lidar, scan));
  }
  if (on_progress_) on_progress_(SecondsSince(sim::kSimulationEpoch, scan.received), images_);
}

void DriveBagWriter::OnImage(sim::SimulatedImage image) {
  const sim::SimulatedCamera& camera = sensors_.cameras[image.camera];
  const ros::Time received = ToRos(image.received);
  if (IsCompressed(camera.encoding)) {
    bag_.write(camera.topic, received, MakeCompressedMessage(camera, image));
  } else {
    bag_.write(camera.topic, received, MakeImageMessage(camera, image));
  }
  if (camera.camera_info != sim::CameraInfoContent::kNone) {
    bag_.write(CameraInfoTopic(camera), received, MakeCameraInfo(camera, image));
  }
  ++images_;
  if (on_progress_) on_progress_(SecondsSince(sim::kSimulationEpoch, image.received), images_);
}

void DriveBagWriter::Finish() {
  bag_.close();
  std::filesystem::rename(part_path_, path_);
  finished_ = true;
}

}  // namespace mlic
