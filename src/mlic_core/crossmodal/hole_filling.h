#pragma once

#include "mlic_core/crossmodal/intensity_map.h"
#include "mlic_core/crossmodal/rendered_view.h"

namespace mlic {

// Closes the gaps that chance leaves between the points of a surface: pixels with the same plane-like surface
// to the left, to the right, above and below, none farther than a few of its points' spacings. Values are
// interpolated; the point is the nearest one's. pixels_per_radian: of the camera, roughly.
void FillHoles(const IntensityMap& map, double pixels_per_radian, RenderedView* view);

}  // namespace mlic
