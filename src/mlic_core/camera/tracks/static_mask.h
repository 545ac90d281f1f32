#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

#include "mlic_core/camera/tracks/tracks.h"
#include "mlic_core/common/progress.h"
#include "mlic_core/sensors/images.h"

namespace mlic {

// What never changes in a camera's images while the vehicle moves: its own body, dirt on the lens, and the
// dark outside of a fisheye's image circle.
struct StaticMaskOptions {
  int images = 40;                 // looked at, spread evenly over the keyframes; from: guard, time
  double largest_deviation = 6.0;  // gray values: the robust spread over time of a pixel that does not change
  double least_share = 0.004;      // of the image: smaller regions are chance, not the vehicle; from: guard
  int margin = 6;                  // px added around
};

// CV_8UC1 of the camera's image size: 0 where the recording's mask is 0 or where the images of these
// keyframes (all of one camera) never change, 255 elsewhere. With fewer than 8 keyframes: the recording's
// mask alone.
cv::Mat FindStaticPixels(const CameraRecording& recording, const std::vector<Keyframe>& keyframes,
                         const StaticMaskOptions& options, const CancellationToken* cancellation = nullptr);

}  // namespace mlic
