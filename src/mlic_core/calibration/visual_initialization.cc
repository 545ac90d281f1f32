#include "mlic_core/calibration/visual_initialization.h"

#include "mlic_core/common/error.h"

namespace mlic {

Initialization InitializeFromCameras(const Rig&, const Dataset&, const std::vector<CameraStart>&,
                                     const std::vector<TrackSet>&, const CancellationToken&,
                                     CameraInitialization*) {
  throw InputError(
      "the rig file has no enabled LiDAR under 'lidars': cameras and IMU alone are not supported yet; add a "
      "LiDAR");
}

}  // namespace mlic
