#include "mlic_core/summary/camera_result.h"

#include <cmath>
#include <utility>

#include "mlic_core/common/order_statistics.h"
#include "mlic_core/uncertainty/alike_lenses.h"

namespace mlic {
namespace {

// px: within how much of the lens's centre nearly all observations of the camera lie.
double ReachOfLandmarks(const Adjustment& adjustment, std::size_t camera) {
  constexpr double kNearlyAll = 0.95;  // from: definition
  const std::vector<double>& lens = adjustment.state.cameras[camera].intrinsics.parameters;
  const Eigen::Vector2d centre(lens[2], lens[3]);
  std::vector<double> distances;
  for (const DriveTerms& drive : adjustment.problem.drives) {
    for (const LandmarkObservation& o : drive.landmarks.observations) {
      if (o.camera == static_cast<int>(camera)) distances.push_back((o.pixel - centre).norm());
    }
  }
  return Quantile(std::move(distances), kNearlyAll);
}

}  // namespace

void AddIntrinsics(const CameraCalibration& camera, const ObservabilityAnalysis::Intrinsics& analysis,
                   SensorResult* result) {
  result->type = SensorResult::Type::kCamera;
  result->intrinsics = camera.intrinsics;
  result->intrinsics_sigma = analysis.sigmas;
  result->intrinsics_fixed = analysis.held;
  if (!camera.rolling_shutter) return;
  result->rolling_shutter_readout = camera.readout;
  result->readout_sigma = analysis.readout_sigma;
}

void AddAlikeLenses(const Adjustment& adjustment, std::size_t camera, SensorResult* result) {
  const Eigen::VectorXd spread =
      SpreadOfAlikeLenses(adjustment.state.cameras[camera].intrinsics, ReachOfLandmarks(adjustment, camera));
  for (std::size_t i = 0; i < result->intrinsics_sigma.size(); ++i) {
    double& sigma = result->intrinsics_sigma[i];
    if (sigma > 0.0) sigma = std::hypot(sigma, spread[static_cast<Eigen::Index>(i)]);
  }
}

}  // namespace mlic
