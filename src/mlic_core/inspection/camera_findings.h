#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "mlic_core/camera/features/image_quality.h"
#include "mlic_core/common/time.h"
#include "mlic_core/inspection/finding.h"
#include "mlic_core/sensors/rig.h"

namespace mlic {

// What one image looks like.
struct ImageSample {
  TimeNs record = 0;
  int width = 0, height = 0;
  std::string encoding;
  ImageQuality quality;
  double brightness = 0.0;  // mean gray value, 0 to 255
  // Root mean square of the gradient by that of the image at half the size, both per pixel: 0.5 for an image
  // without fine detail, out of focus or moved; above 0.8 for a sharp one.
  double detail = 0.0;
  std::uint64_t digest = 0;  // equal for identical pixels
};

// image: 8 bits, 1 or 3 channels; record, encoding are left at their defaults.
ImageSample MeasureImage(const cv::Mat& image);

// What was read of one camera topic: a sparse sample of its images, in order of time.
struct CameraSurvey {
  CameraConfig config;
  std::size_t undecodable = 0;  // of the sampled images
  std::string first_fault;
  std::vector<ImageSample> samples;
};

// Decoding, size and encoding, exposure, blur, identical images, and whether the rig's field of view or
// intrinsics go with the images. Places are seconds after `begin` on the recorder's clock. vehicle_moves:
// identical images are then the driver's fault.
Findings CameraFindings(const CameraSurvey& camera, TimeNs begin, bool vehicle_moves);

}  // namespace mlic
