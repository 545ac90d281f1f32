#pragma once

#include <functional>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "mlic_core/camera/tracks/tracks.h"
#include "mlic_core/common/progress.h"
#include "mlic_core/geometry/rigid_transform.h"
#include "mlic_core/sensors/images.h"

namespace mlic {

// Pose in the map of any frame that is fixed to the vehicle (s since the drive's epoch); nothing outside the
// known span. A clock that is some tens of milliseconds off does no harm here.
using VehiclePose = std::function<std::optional<RigidTransform>(double time)>;

struct KeyframeOptions {
  int most_keyframes = 80;       // of one camera
  double least_interval = 0.15;  // s
  // Motion between two keyframes is rotation (rad) plus translation over this depth (m).
  double scene_depth = 10.0;
  double least_motion = 0.02;  // rad; a vehicle that stands still gives no keyframes
  int candidates = 3;          // images about each wanted place, of which the sharpest is taken
};

// Images spread evenly over the motion (over time where `pose` is empty), the sharpest well exposed one of
// some neighbours each. Ordered by time. Images that cannot be decoded throw InputError.
std::vector<Keyframe> SelectKeyframes(const CameraRecording& recording, int camera, const VehiclePose& pose,
                                      const KeyframeOptions& options,
                                      const CancellationToken* cancellation = nullptr);

// What never changes in a camera's images while the vehicle moves: its own body, dirt on the lens, and the
// dark outside of a fisheye's image circle.
struct StaticMaskOptions {
  int images = 40;                 // looked at, spread evenly over the keyframes
  double largest_deviation = 6.0;  // gray values: the robust spread over time of a pixel that does not change
  double least_share = 0.004;      // of the image: smaller regions are chance, not the vehicle
  int margin = 6;                  // px added around
};

// CV_8UC1 of the camera's image size: 0 where the recording's mask is 0 or where the images of these
// keyframes (all of one camera) never change, 255 elsewhere. With fewer than 8 keyframes: the recording's
// mask alone.
cv::Mat FindStaticPixels(const CameraRecording& recording, const std::vector<Keyframe>& keyframes,
                         const StaticMaskOptions& options, const CancellationToken* cancellation = nullptr);

}  // namespace mlic
