#pragma once

#include <functional>
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
  int most_keyframes = 80;       // of one camera in a minute; from: guard, time and memory
  double least_interval = 0.15;  // s; from: guard, time: of fast turns and drives below 12 s
  // Without poses: a camera in the hand turns away from what it saw within a second. from: guard, plain
  // drives are closer.
  double largest_interval = 0.5;  // s; as many keyframes as that takes
  // Motion between two keyframes is rotation (rad) plus translation over this depth (m).
  double scene_depth = 10.0;
  // from: guard, a drive's keyframes are 0.1 and more apart.
  double least_motion = 0.02;  // rad; a vehicle that stands still gives no keyframes
  int candidates = 3;  // images about each wanted place, of which the sharpest is taken; from: guard, time
};

// As many keyframes of one camera as a drive of that many seconds has at most, by default: those of a minute
// in shorter ones, too; without poses the largest interval decides.
double MostKeyframes(double seconds, bool with_poses);

// Images spread evenly over the motion (over time where `pose` is empty), the sharpest well exposed one of
// some neighbours each. Ordered by time. Images that cannot be decoded throw InputError.
std::vector<Keyframe> SelectKeyframes(const CameraRecording& recording, int camera, const VehiclePose& pose,
                                      const KeyframeOptions& options,
                                      const CancellationToken* cancellation = nullptr);

}  // namespace mlic
