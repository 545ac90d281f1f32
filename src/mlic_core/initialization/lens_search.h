#pragma once

#include <optional>
#include <vector>

#include "mlic_core/initialization/lens_fit.h"
#include "mlic_core/sensors/rig.h"

namespace mlic {

// What a search for a lens starts from.
struct LensSearch {
  CameraIntrinsics from_field_of_view;  // IntrinsicsFromFieldOfView; good to 15 percent
  std::optional<ExtrinsicGuess> guess;
  std::optional<double> time_offset;
  std::optional<LensHypothesis> known;  // found before on nearly the same trajectory: only fitted again
};

// The lens, rotation and time offset with which the matches agree best when the camera turns as the
// trajectory (of each drive) does. Lenses of several bends but the same field of view (perspective, between
// stereographic and perspective, beyond stereographic) give visual rotations, these a rotation and a time
// offset (camera_rotation.h), and from there FitLens goes on; the fit of least cost counts. Nothing where
// none gets so far.
std::optional<LensFit> SearchLens(const std::vector<PixelMatches>& pairs,
                                  const std::vector<const SplitSpline*>& T_map_imu, const LensSearch& search);

}  // namespace mlic
