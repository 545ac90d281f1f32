#include "mlic_core/summary/result_assembly.h"

#include <sys/resource.h>

#include <cmath>
#include <cstdio>

#include "mlic_core/common/error.h"
#include "mlic_core/initialization/guess_check.h"
#include "mlic_core/problem/layout.h"
#include "mlic_core/problem/observability_limits.h"
#include "mlic_core/summary/camera_views.h"
#include "mlic_core/summary/imu_verdict.h"
#include "mlic_core/summary/map_projections.h"
#include "mlic_core/summary/residual_summary.h"
#include "mlic_core/summary/snapshot.h"

namespace mlic {
namespace {

double PeakMemoryMegabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss / 1024.0;
}

// What LiDARs and cameras have in common, LiDARs first, as in Layout.
struct Sensor {
  std::string name, frame_id, topic;
  bool fixed = false, has_guess = false;
  SensorCalibration calibration;
};

std::vector<Sensor> AllSensors(const Rig& rig, const CalibrationState& state) {
  std::vector<Sensor> sensors;
  const auto add = [&](const auto& config, const SensorCalibration& calibration) {
    sensors.push_back({config.name, config.frame_id.empty() ? config.name : config.frame_id, config.topic,
                       config.fixed, config.guess.has_value(), calibration});
  };
  for (std::size_t l = 0; l < state.lidars.size(); ++l) add(rig.lidars[l], state.lidars[l]);
  for (std::size_t c = 0; c < state.cameras.size(); ++c) add(rig.cameras[c], state.cameras[c].sensor);
  return sensors;
}

SensorResult MakeSensor(const Sensor& sensor, const ObservabilityAnalysis& analysis, std::size_t s) {
  SensorResult result;
  result.name = sensor.name;
  result.frame_id = sensor.frame_id;
  result.topic = sensor.topic;
  result.calibration = sensor.calibration;
  result.sigma = analysis.sigmas[s];
  result.translation_observable = analysis.sensors[s].translation;
  result.rotation_observable = analysis.sensors[s].rotation;
  result.time_offset_observable = analysis.sensors[s].time_offset;
  result.unobservable = analysis.sensors[s].directions;
  return result;
}

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

// Poses, offsets and intrinsics alone, of the sensors that are shown in the end.
std::vector<SensorResult> InitialSensors(const Rig& rig, const CalibrationState& initial,
                                         const std::vector<bool>& shown) {
  const std::vector<Sensor> sensors = AllSensors(rig, initial);
  std::vector<SensorResult> results;
  for (std::size_t s = 0; s < sensors.size(); ++s) {
    if (!shown[s]) continue;
    SensorResult result;
    result.name = sensors[s].name;
    result.frame_id = sensors[s].frame_id;
    result.calibration = sensors[s].calibration;
    const SensorId id = initial.Sensors().At(s);
    if (!id.IsLidar()) AddIntrinsics(initial.cameras[id.index], {}, &result);
    result.readout_sigma.reset();
    results.push_back(result);
  }
  return results;
}

// Reasons for refusal of one sensor; none when its result may be trusted.
std::vector<std::string> Judge(const Sensor& config, const ObservabilityAnalysis::Sensor& sensor,
                               const PoseSigma& sigma) {
  std::vector<std::string> reasons;
  if (!sigma.rotation.allFinite() || !sigma.translation.allFinite() || !std::isfinite(sigma.time_offset)) {
    return {config.name +
            ": its sigmas are not numbers, as the solve came out singular; turn about more axes"};
  }
  const auto all = [](const std::array<bool, 3>& axes) { return axes[0] && axes[1] && axes[2]; };
  if (!all(sensor.rotation)) {
    reasons.push_back(config.name +
                      ": the motion does not show its whole rotation to 0.5 deg; turn about more axes");
  }
  if (!sensor.time_offset) {
    reasons.push_back(config.name +
                      ": the motion does not show its time offset to 5 ms; turn more, and not evenly");
  }
  bool translation_shown = all(sensor.translation);
  for (const UnobservableDirection& direction : sensor.directions) {
    translation_shown &= direction.quantity != UnobservableDirection::Quantity::kTranslation;
  }
  if (!translation_shown && !config.has_guess) {
    reasons.push_back(config.name +
                      ": the motion does not show its whole translation to 5 cm, and the rig file gives no "
                      "T_imu_sensor to fall back on; measure it by hand, or turn about more axes");
  }
  return reasons;
}

// Cameras that found nothing of the map keep what tracks say of them.
void WarnOfUnmatched(const Rig& rig, const Adjustment& adjustment, CalibrationResult* result) {
  std::vector<std::size_t> matches(rig.cameras.size(), 0);
  for (const LandmarkSet& set : adjustment.problem.landmarks) {
    for (std::size_t p = 0; p < set.points.size(); ++p) {
      if (set.IsOnMap(p)) ++matches[set.observations[set.begin[p]].camera];
    }
  }
  for (std::size_t c = 0; c < matches.size(); ++c) {
    if (matches[c] > 0 || !adjustment.cameras.found[c]) continue;
    result->warnings.push_back(
        rig.cameras[c].name +
        ": its photos do not match the LiDAR map; its result rests on image tracks alone");
  }
}

// Points without times got theirs from the azimuth, so that their scans' offset to the stamps is known to
// where in the turn the driver cuts: good to some degrees.
void InflateTimesFromAzimuth(const Dataset& dataset, ObservabilityAnalysis* analysis) {
  constexpr double kAzimuthSigma = 0.02;  // of a turn, 7 deg; from: derivation
  for (std::size_t l = 0; l < dataset.drives[0].lidars.size(); ++l) {
    const LidarRecording& lidar = dataset.drives[0].lidars[l];
    if (!lidar.point_times_from_azimuth) continue;
    const int at = Layout::Lidar(l) + 6;
    const double sigma = kAzimuthSigma * lidar.scan_period;
    analysis->covariance(at, at) += sigma * sigma;
    analysis->data_covariance(at, at) += sigma * sigma;
    analysis->sigmas[l].time_offset = std::sqrt(analysis->covariance(at, at));
  }
}

// A LiDAR that was not aligned and came to rest where its scans contradict the trajectory.
bool DoesNotFit(const Adjustment& adjustment, std::size_t lidar) {
  constexpr double kExcess = 2.0;
  return adjustment.unaligned_lidars[lidar] && !adjustment.scale.stamps.empty() &&
         adjustment.scale.stamps[lidar].excess > kExcess;
}

template <typename Config>
void WarnOfGuess(const Config& config, const SensorCalibration& found, std::vector<std::string>* warnings) {
  if (!config.guess || config.fixed) return;
  const std::string warning = DescribeIfFarFromGuess(*config.guess, found.T_imu_sensor);
  if (!warning.empty()) warnings->push_back(config.name + ": " + warning);
}

// Of sensors whose scans do not keep one time offset to the IMU.
void WarnOfStamps(const std::vector<Sensor>& sensors, const std::vector<StampErrors>& errors,
                  std::vector<std::string>* warnings) {
  constexpr double kNotable = 4.0;  // of variances: sigmas are doubled; from: definition
  for (std::size_t s = 0; s < errors.size(); ++s) {
    if (errors[s].excess < kNotable) continue;
    if (errors[s].wanders) {
      warnings->push_back(
          sensors[s].name +
          ": its clock does not keep step with the IMU's, it drifts or jumps within the drive; "
          "no time offset is right for all of it: synchronise the clocks, or cut the drive by "
          "--start and --duration");
    } else {
      char text[200];
      std::snprintf(
          text, sizeof(text),
          ": its stamps jitter by %.1f ms from message to message against the IMU's; let the device "
          "stamp them, not the host on arrival",
          1e3 * errors[s].jitter);
      warnings->push_back(sensors[s].name + text);
    }
  }
}

// Every pair whose sensors are shown, and those that their own data tie to each other. lost: of each sensor,
// its place rests on nothing.
std::vector<PairResult> MakePairs(const std::vector<Sensor>& sensors, const std::vector<bool>& shown,
                                  const std::vector<bool>& lost, const ObservabilityAnalysis& analysis) {
  std::vector<PairResult> pairs;
  for (std::size_t a = 0; a < sensors.size(); ++a) {
    for (std::size_t b = a + 1; b < sensors.size(); ++b) {
      if (lost[a] || lost[b]) continue;
      const auto sigmas = [&](const Eigen::MatrixXd& from) {
        return MakePair(sensors[a].calibration, sensors[b].calibration, JointCovariance(from, a, b));
      };
      const PoseSigma from_data = sigmas(analysis.data_covariance).sigma;
      const bool pair_shown = from_data.translation.maxCoeff() < kTranslationLimit &&
                              from_data.rotation.maxCoeff() < kRotationLimit;
      if (!pair_shown && !(shown[a] && shown[b])) continue;
      PairResult pair = sigmas(analysis.covariance);
      pair.a = sensors[a].name;
      pair.b = sensors[b].name;
      pairs.push_back(pair);
    }
  }
  return pairs;
}

}  // namespace

void FinishRefused(CalibrationResult* result) {
  result->trusted = false;
  result->peak_memory_megabytes = PeakMemoryMegabytes();
}

void AssembleResult(const Rig& rig, const Dataset& dataset, const Adjustment& adjustment,
                    CalibrationResult* result) {
  const CalibrationState& state = adjustment.state;
  Check(IsFinite(state), "the calibration holds what is not a number; please report this with the log");
  ObservabilityAnalysis analysis = Analyze(adjustment, dataset);
  InflateTimesFromAzimuth(dataset, &analysis);
  const std::vector<Sensor> sensors = AllSensors(rig, state);
  const SensorOrder order = state.Sensors();
  const std::vector<bool>& found = adjustment.cameras.found;
  std::vector<bool> shown, lost;
  for (std::size_t s = 0; s < sensors.size(); ++s) {
    const SensorId id = order.At(s);
    lost.push_back(id.IsLidar() ? adjustment.rejected_lidars[id.index] || DoesNotFit(adjustment, id.index)
                                : !found[id.index]);
    std::vector<std::string> reasons;
    if (id.IsLidar() && lost[s]) reasons = {WhyRejected(rig.lidars[id.index])};
    if (!lost[s] && !sensors[s].fixed) reasons = Judge(sensors[s], analysis.sensors[s], analysis.sigmas[s]);
    shown.push_back(!lost[s] && reasons.empty());
    result->reasons.insert(result->reasons.end(), reasons.begin(), reasons.end());
  }
  if (!state.lidars.empty() && adjustment.problem.planes[0].planes.size() < 20) {
    result->reasons.push_back("the map has hardly any planes; record near buildings or in a furnished hall");
  }
  if (adjustment.rounds.unsettled > 0.5) {
    char text[200];
    std::snprintf(text, sizeof(text),
                  "the calibration has not converged: the last round moved it by %.1f of its sigma, which "
                  "the sigmas here include",
                  adjustment.rounds.unsettled);
    result->warnings.push_back(text);
  }
  JudgeImuAgreement(dataset, adjustment, result);
  WarnOfStamps(sensors, adjustment.scale.stamps, &result->warnings);
  if (adjustment.rounds.landmarks == Landmarks::kTracksAndMap) WarnOfUnmatched(rig, adjustment, result);
  result->trusted = result->reasons.empty();
  for (std::size_t s = 0; s < sensors.size(); ++s) {
    if (!shown[s]) continue;
    result->sensors.push_back(MakeSensor(sensors[s], analysis, s));
    const SensorId id = order.At(s);
    if (id.IsLidar()) {
      WarnOfGuess(rig.lidars[id.index], result->sensors.back().calibration, &result->warnings);
      continue;
    }
    const std::size_t c = id.index;
    WarnOfGuess(rig.cameras[c], result->sensors.back().calibration, &result->warnings);
    AddIntrinsics(state.cameras[c], analysis.cameras[c], &result->sensors.back());
    const std::vector<HeldOutMatches>& held_out = adjustment.map.held_out_errors;
    if (c < held_out.size() && held_out[c].count > 0) result->sensors.back().held_out = held_out[c];
  }
  result->initial_sensors = InitialSensors(rig, adjustment.initial, shown);
  result->pairs = MakePairs(sensors, shown, lost, analysis);
  result->imu = state.Imu(0);
  result->gravity = state.Gravity();
  result->alignment = AlignmentOf(adjustment);
  for (std::size_t d = 0; d < state.drives.size(); ++d) {
    const SplitSpline& trajectory = state.drives[d].trajectory;
    result->trajectories.push_back(
        SampleTrajectory(dataset.drives[d], trajectory, MapOrigin(trajectory), 0.01));
  }
  result->map =
      SampleMap(state, adjustment.problem.planes[0], MapOrigin(state.drives[0].trajectory), 2000000);
  if (adjustment.rounds.landmarks == Landmarks::kTracksAndMap) {
    result->projections =
        ProjectOnPhotos(rig, dataset, adjustment.map.cameras_before, state, adjustment.problem.landmarks[0]);
  }
  result->residuals = SummarizeResiduals(rig, dataset, adjustment);
  if (!adjustment.problem.landmarks.empty()) {
    result->views = ChooseViews(rig, dataset.drives[0], state, adjustment.problem.landmarks[0]);
    result->keyframes = UsedKeyframes(rig, dataset, adjustment.problem.landmarks);
  }
  result->peak_memory_megabytes = PeakMemoryMegabytes();
}

}  // namespace mlic
