#pragma once

#include <optional>

#include "mlic_core/sensors/camera_intrinsics.h"

namespace mlic {

// Other intrinsics of double_sphere, of another xi, that project alike: from 0.2 to 0.3 px off when f, xi and
// alpha change together, the difference falls back to some hundredths of a pixel at a second place (of a lens
// of 180 degrees with xi -0.18 at 0.28). A solve that comes to the one does not find its way to the other.
// Nothing where there is no other place, or it is off by more than half a pixel in the mean (rms) over the
// image. The centre and the ratio of focal lengths stay.
std::optional<CameraIntrinsics> DoubleSphereTwin(const CameraIntrinsics& intrinsics);

// The lens of this xi that projects most alike. Half-way between the two places above a change of xi does not
// show to first order, and a solve that starts there, as with xi 0, has nothing to go by. Nothing where there
// is none.
std::optional<CameraIntrinsics> DoubleSphereOfXi(const CameraIntrinsics& intrinsics, double xi);

}  // namespace mlic
