#pragma once

#include <cstdint>
#include <string>

#include "mlic_core/sensors/rig.h"

namespace mlic::sim {

// How a camera's driver writes its images.
enum class ImageEncoding {
  kMono8,       // sensor_msgs/Image
  kBgr8,        // sensor_msgs/Image
  kBayerRggb8,  // sensor_msgs/Image
  kJpeg,        // sensor_msgs/CompressedImage, colour
  kMonoJpeg     // sensor_msgs/CompressedImage, gray
};

// What CameraInfo says about the intrinsics.
enum class CameraInfoContent {
  kNone,   // no such message
  kEmpty,  // all zero, as drivers do without a calibration
  kTrue
};

struct SimulatedCamera {
  std::string name;
  std::string topic;
  std::string frame_id;
  SensorCalibration calibration;  // the truth; the offset belongs to row 0, in the middle of its exposure
  CameraIntrinsics intrinsics;    // the truth
  double fov_deg = 90.0;          // horizontal, roughly, as the rig file says it
  double rate = 10.0;             // Hz
  double phase = 0.0;             // first image after the drive's begin, s, IMU clock
  bool rolling_shutter = false;
  double readout = 0.0;   // s: row v is exposed readout * v / height after row 0
  double exposure = 0.0;  // s: motion blur
  // s; where positive, the exposure is automatic between this and `exposure`. Stamps keep their distance to
  // its begin, so that its middle moves against them; the offset is that of the drive's mean exposure.
  double shortest_exposure = 0.0;
  ImageEncoding encoding = ImageEncoding::kMono8;
  CameraInfoContent camera_info = CameraInfoContent::kEmpty;
  int jpeg_quality = 90;
  double gain = 1.0;             // of the exposure: 1 shows a white wall in the sun just below saturation
  double exposure_drift = 0.12;  // share by which the exposure wanders, over about 20 s
  double vignetting = 0.35;      // share of light that the corners lose
  double full_well = 10000.0;    // electrons at saturation: shot noise
  double read_noise = 10.0;      // electrons
};

}  // namespace mlic::sim
