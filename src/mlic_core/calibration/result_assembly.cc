#include "mlic_core/calibration/result_assembly.h"

#include <sys/resource.h>

#include <cmath>

#include "mlic_core/calibration/refinement.h"
#include "mlic_core/calibration/residual_summary.h"
#include "mlic_core/calibration/snapshot.h"

namespace mlic {
namespace {

double PeakMemoryMegabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss / 1024.0;
}

SensorResult MakeSensor(const LidarConfig& lidar, const SensorCalibration& calibration,
                        const ObservabilityAnalysis& analysis, std::size_t l) {
  SensorResult sensor;
  sensor.name = lidar.name;
  sensor.type = SensorResult::Type::kLidar;
  sensor.frame_id = lidar.frame_id.empty() ? lidar.name : lidar.frame_id;
  sensor.calibration = calibration;
  sensor.sigma = analysis.sigmas[l];
  sensor.translation_observable = analysis.sensors[l].translation;
  sensor.rotation_observable = analysis.sensors[l].rotation;
  sensor.time_offset_observable = analysis.sensors[l].time_offset;
  sensor.unobservable = analysis.sensors[l].directions;
  return sensor;
}

// Reasons for refusal of one LiDAR; none when its result may be trusted.
std::vector<std::string> Judge(const LidarConfig& lidar, const ObservabilityAnalysis::Sensor& sensor) {
  std::vector<std::string> reasons;
  const auto all = [](const std::array<bool, 3>& axes) { return axes[0] && axes[1] && axes[2]; };
  if (!all(sensor.rotation)) {
    reasons.push_back(lidar.name +
                      ": the motion does not show its whole rotation to 0.5 deg; turn about more axes");
  }
  if (!sensor.time_offset) {
    reasons.push_back(lidar.name +
                      ": the motion does not show its time offset to 5 ms; turn more, and not evenly");
  }
  bool translation_shown = all(sensor.translation);
  for (const UnobservableDirection& direction : sensor.directions) {
    translation_shown &= direction.quantity != UnobservableDirection::Quantity::kTranslation;
  }
  if (!translation_shown && !lidar.guess) {
    reasons.push_back(lidar.name +
                      ": the motion does not show its whole translation to 5 cm, and the rig file gives no "
                      "T_imu_sensor to hold; measure it by hand, or turn about more axes");
  }
  return reasons;
}

}  // namespace

std::size_t ImuSampleCount(const Dataset& dataset) {
  std::size_t count = 0;
  for (const Drive& drive : dataset.drives) count += drive.imu.size();
  return count;
}

void FinishRefused(CalibrationResult* result) {
  result->trusted = false;
  result->peak_memory_megabytes = PeakMemoryMegabytes();
}

void AssembleResult(const Rig& rig, const Dataset& dataset, const Refinement& refinement,
                    CalibrationResult* result) {
  const CalibrationState& state = refinement.state();
  const ObservabilityAnalysis analysis = refinement.Analyze();
  std::vector<bool> shown;
  for (std::size_t l = 0; l < rig.lidars.size(); ++l) {
    const auto reasons =
        rig.lidars[l].fixed ? std::vector<std::string>() : Judge(rig.lidars[l], analysis.sensors[l]);
    shown.push_back(reasons.empty());
    result->reasons.insert(result->reasons.end(), reasons.begin(), reasons.end());
  }
  if (refinement.problem().planes[0].planes.size() < 20) {
    result->reasons.push_back("the map has hardly any planes; record near buildings or in a furnished hall");
  }
  if (!refinement.converged()) {
    result->warnings.push_back(
        "the calibration still moved by more than a tenth of its sigma in the last round");
  }
  result->trusted = result->reasons.empty();
  for (std::size_t l = 0; l < rig.lidars.size(); ++l) {
    if (shown[l]) result->sensors.push_back(MakeSensor(rig.lidars[l], state.lidars[l], analysis, l));
  }
  for (std::size_t a = 0; a < rig.lidars.size(); ++a) {
    for (std::size_t b = a + 1; b < rig.lidars.size(); ++b) {
      Eigen::Matrix<double, 14, 14> covariance, data;
      const auto gather = [&](const Eigen::MatrixXd& from, Eigen::Matrix<double, 14, 14>* to) {
        *to << from.block<7, 7>(7 * a, 7 * a), from.block<7, 7>(7 * a, 7 * b), from.block<7, 7>(7 * b, 7 * a),
            from.block<7, 7>(7 * b, 7 * b);
      };
      gather(analysis.covariance, &covariance);
      gather(analysis.data_covariance, &data);
      PairResult pair = MakePair(state.lidars[a], state.lidars[b], covariance);
      const PoseSigma from_data = MakePair(state.lidars[a], state.lidars[b], data).sigma;
      const bool pair_shown =
          from_data.translation.maxCoeff() < 0.05 && from_data.rotation.maxCoeff() < 0.5 * M_PI / 180.0;
      if (!pair_shown && !(shown[a] && shown[b])) continue;
      pair.a = rig.lidars[a].name;
      pair.b = rig.lidars[b].name;
      result->pairs.push_back(pair);
    }
  }
  result->imu = state.Imu(0);
  result->gravity = kGravity;
  for (std::size_t d = 0; d < state.drives.size(); ++d) {
    const SplitSpline& trajectory = state.drives[d].trajectory;
    result->trajectories.push_back(
        SampleTrajectory(dataset.drives[d], trajectory, MapOrigin(trajectory), 0.01));
  }
  result->map =
      SampleMap(state, refinement.problem().planes[0], MapOrigin(state.drives[0].trajectory), 2000000);
  result->residuals = SummarizeResiduals(rig, dataset, refinement);
  result->peak_memory_megabytes = PeakMemoryMegabytes();
}

}  // namespace mlic
