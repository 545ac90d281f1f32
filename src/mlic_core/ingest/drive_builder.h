#pragma once

#include <string>
#include <vector>

#include "mlic_core/ingest/drive_notes.h"
#include "mlic_core/ingest/image_stream.h"
#include "mlic_core/ingest/imu_check.h"
#include "mlic_core/ingest/lidar_format.h"
#include "mlic_core/ingest/scan_reader.h"
#include "mlic_core/sensors/measurements.h"

namespace mlic {

// What was read of one drive, in order of recording: before sorting, checking and leaving out.
struct DriveMessages {
  std::vector<StampedImu> imu;
  std::vector<std::vector<ReadScan>> lidars;  // one for each LiDAR format
  std::vector<ImageStream> cameras;           // one for each image format
};

// Sorts and cleans the messages, reports what was odd about them and puts all times on one epoch, the first
// IMU stamp. The images are not decoded, and have no masks. Throws UnusableSensor when a LiDAR or camera has
// nothing usable or does not overlap with the IMU in time, InputError for what is wrong with the IMU.
Drive BuildDrive(DriveMessages messages, const std::string& imu_topic,
                 const std::vector<LidarFormat>& lidar_formats, const std::vector<ImageFormat>& image_formats,
                 DriveNotes& notes);

}  // namespace mlic
