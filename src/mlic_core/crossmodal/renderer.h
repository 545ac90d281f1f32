#pragma once

#include <memory>
#include <vector>

#include "mlic_core/crossmodal/intensity_map.h"
#include "mlic_core/crossmodal/rendered_view.h"
#include "mlic_core/sensors/camera_intrinsics.h"

namespace mlic {

struct RenderOptions {
  double farthest = 80.0;  // m, points beyond are left out
};

// Draws one map through one camera. Thread-safe; one view is drawn by one thread, so draw many in parallel.
class ViewRenderer {
 public:
  // The map must outlive the renderer.
  ViewRenderer(const IntensityMap& map, const CameraIntrinsics& intrinsics, const RenderOptions& options);
  ~ViewRenderer();

  RenderedView Render(const ViewPose& pose) const;

 private:
  struct Implementation;
  std::unique_ptr<const Implementation> implementation_;
};

// Draws all views in parallel.
std::vector<RenderedView> RenderViews(const IntensityMap& map, const CameraIntrinsics& intrinsics,
                                      const std::vector<ViewPose>& poses, const RenderOptions& options);

}  // namespace mlic
