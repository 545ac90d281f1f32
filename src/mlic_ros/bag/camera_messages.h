#pragma once

#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>

#include <string>

#include "mlic_sim/simulation.h"

namespace mlic {

// A simulated image in the words of a camera driver (see sim::ImageEncoding). Stamps are on the camera's
// clock.
sensor_msgs::Image MakeImageMessage(const sim::SimulatedCamera& camera, const sim::SimulatedImage& image);
sensor_msgs::CompressedImage MakeCompressedMessage(const sim::SimulatedCamera& camera,
                                                   const sim::SimulatedImage& image);

// The true intrinsics, or zeros (sim::CameraInfoContent::kEmpty). double_sphere has no name in ROS: D then
// holds xi and alpha.
sensor_msgs::CameraInfo MakeCameraInfo(const sim::SimulatedCamera& camera, const sim::SimulatedImage& image);

bool IsCompressed(sim::ImageEncoding encoding);

// The topic of a camera's CameraInfo, as image_transport expects it: beside the images' own name, without the
// transport's.
std::string CameraInfoTopic(const sim::SimulatedCamera& camera);

}  // namespace mlic
