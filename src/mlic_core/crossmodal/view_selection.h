#pragma once

#include <vector>

#include "mlic_core/crossmodal/renderer.h"

namespace mlic {

// An image that may be matched to the map.
struct ViewCandidate {
  ViewPose pose;
  double quality = 1.0;  // 0 to 1: how sharp and well exposed it is
};

struct ViewSelectionOptions {
  std::size_t count = 16;            // views wanted; from: structural, the caller sets it
  std::size_t most_candidates = 60;  // looked at; taken evenly from more; from: guard, time
};

// The views that together say most about the camera's pose and intrinsics: the greedy choice that makes the
// determinant of their information largest. The information comes from parts of the image where a small
// drawing of the map shows structure; matches all over the image, corners included, fix the distortion, near
// and far ones together tell translation from rotation. A place of the map that earlier views matched counts
// less, as its own error comes again: so views are far from each other. Indices in order of choice, fewer
// than wanted where no more views show any structure.
std::vector<std::size_t> SelectViews(const IntensityMap& map, const CameraIntrinsics& intrinsics,
                                     const std::vector<ViewCandidate>& candidates,
                                     const ViewSelectionOptions& options);

// The camera at another image size: a pixel of the new one covers 1 / scale pixels of the old one.
CameraIntrinsics ScaledIntrinsics(const CameraIntrinsics& intrinsics, double scale);

}  // namespace mlic
