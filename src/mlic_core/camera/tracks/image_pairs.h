#pragma once

#include <cstdint>
#include <vector>

#include "mlic_core/camera/tracks/tracks.h"
#include "mlic_core/geometry/rigid_transform.h"
#include "mlic_core/sensors/camera_model.h"

namespace mlic {

// Two keyframes to be matched, a < b.
struct ImagePair {
  std::int32_t a = 0;
  std::int32_t b = 0;
};

struct SequentialPairOptions {
  int window = 3;  // each keyframe with that many followers of its camera; from: guard, time
  // from: guard, time.
  int largest_interval = 8;  // beyond the window, followers at doubling intervals up to this one
};

// Pairs of one camera by order of time alone: for when no poses are known.
std::vector<ImagePair> SequentialPairs(const std::vector<Keyframe>& keyframes,
                                       const SequentialPairOptions& options = {});

// Predicted pose of a keyframe; intrinsics must outlive the call.
struct PredictedView {
  RigidTransform T_map_camera;
  const CameraIntrinsics* intrinsics = nullptr;
};

struct PredictedPairOptions {
  double nearest = 4.0;  // m, range of depths of the scene
  double farthest = 40.0;
  double least_overlap = 0.25;      // share of the image that the other one sees as well, at the median depth
  double largest_view_angle = 0.6;  // rad, between the two rays to a point: SIFT bears no more
  int most_for_keyframe = 6;        // partners in addition to others' choices; from: guard, time
  double least_time_apart = 2.0;    // s, of pairs of one camera: nearer ones are sequential pairs
};

// Pairs that see the same part of the scene by predicted poses, across cameras and across time: for each
// keyframe the partners that share most with it, spread over cameras and times. Ordered by a, then b.
std::vector<ImagePair> PredictedPairs(const std::vector<Keyframe>& keyframes,
                                      const std::vector<PredictedView>& views,
                                      const PredictedPairOptions& options = {});

// Share of the image of `a`, 0 to 1, whose points at the given depths (m) `b` sees too under an angle of at
// most largest_view_angle (rad); of the depths the median.
double SharedView(const PredictedView& a, const PredictedView& b, const std::vector<double>& depths,
                  double largest_view_angle);

// Both lists without repetition, ordered by a, then b.
std::vector<ImagePair> UnitePairs(const std::vector<ImagePair>& first, const std::vector<ImagePair>& second);

}  // namespace mlic
