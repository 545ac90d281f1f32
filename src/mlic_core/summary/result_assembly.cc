#include "mlic_core/summary/result_assembly.h"

#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "mlic_core/common/error.h"
#include "mlic_core/initialization/guess_check.h"
#include "mlic_core/initialization/loose_lidars.h"
#include "mlic_core/problem/layout.h"
#include "mlic_core/sensors/observability_limits.h"
#include "mlic_core/summary/camera_result.h"
#include "mlic_core/summary/camera_views.h"
#include "mlic_core/summary/checks.h"
#include "mlic_core/summary/ground.h"
#include "mlic_core/summary/imu_verdict.h"
#include "mlic_core/summary/map_projections.h"
#include "mlic_core/summary/residual_summary.h"
#include "mlic_core/summary/sigmas_in_use.h"
#include "mlic_core/summary/snapshot.h"
#include "mlic_core/summary/warnings.h"
#include "mlic_core/uncertainty/clock_drift.h"

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
  bool fixed = false;
  SensorCalibration calibration;
};

std::vector<Sensor> AllSensors(const Rig& rig, const CalibrationState& state) {
  std::vector<Sensor> sensors;
  const auto add = [&](const auto& config, const SensorCalibration& calibration) {
    sensors.push_back({config.name, config.frame_id.empty() ? config.name : config.frame_id, config.topic,
                       config.fixed, calibration});
  };
  for (std::size_t l = 0; l < state.lidars.size(); ++l) add(rig.lidars[l], state.lidars[l]);
  for (std::size_t c = 0; c < state.cameras.size(); ++c) add(rig.cameras[c], state.cameras[c].sensor);
  return sensors;
}

// What the data show, and the bound of it.
struct Shown {
  ObservabilityAnalysis analysis, bound;
};

// drifting: the data show that clocks drift; else what was found of it is noise.
SensorResult MakeSensor(const Sensor& sensor, const Shown& of_data, std::size_t s, bool drifting) {
  const ObservabilityAnalysis& analysis = of_data.analysis;
  SensorResult result;
  result.name = sensor.name;
  result.frame_id = sensor.frame_id;
  result.topic = sensor.topic;
  result.fixed = sensor.fixed;
  result.calibration = sensor.calibration;
  result.sigma = analysis.sigmas[s];
  result.bound = of_data.bound.sigmas[s];
  result.translation_observable = analysis.sensors[s].translation;
  result.rotation_observable = analysis.sensors[s].rotation;
  result.time_offset_observable = analysis.sensors[s].time_offset;
  if (drifting) {
    result.drift_sigma = analysis.sensors[s].drift_sigma;
  } else {
    result.calibration.clock_drift.reset();
  }
  result.unobservable = analysis.sensors[s].directions;
  return result;
}

PointCorrections CorrectionsOf(const CalibrationState& state, std::size_t lidar) {
  PointCorrections corrections;
  if (lidar < state.ranges.size()) {
    corrections.range_offset = state.ranges[lidar].offset;
    corrections.range_slope = state.ranges[lidar].slope;
    corrections.range_walk = state.ranges[lidar].walk;
    corrections.reference_intensity = state.ranges[lidar].reference;
  }
  if (lidar >= state.rings.size()) return corrections;
  for (std::size_t k = 0; k < state.rings[lidar].size(); ++k) {
    const RingCorrection& ring = state.rings[lidar][k];
    if (ring.range == 0.0f && ring.elevation == 0.0f) continue;
    corrections.rings.push_back({static_cast<int>(k), ring.range, ring.elevation});
  }
  return corrections;
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

// What was held is what had not been shown, with the sigmas after the last solve. shown: before it.
void ReportAsHeld(const std::vector<ObservabilityAnalysis::Sensor>& shown, ObservabilityAnalysis* analysis) {
  for (std::size_t s = 0; s < shown.size(); ++s) {
    analysis->sensors[s] = shown[s];
    const Eigen::Matrix3d covariance =
        analysis->covariance.block<3, 3>(Layout::Sensor(s) + 3, Layout::Sensor(s) + 3);
    for (UnobservableDirection& d : analysis->sensors[s].directions) {
      if (d.quantity != UnobservableDirection::Quantity::kTranslation) continue;
      d.sigma = std::sqrt(d.direction.dot(covariance * d.direction));
    }
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

// Failures that refuse reject the sensor that they concern, or are reasons against the whole; others are
// warnings. A check without a failure's words has them elsewhere.
void JudgeChecks(const Rig& rig, CalibrationResult* result) {
  const auto type_of = [&](const std::string& name) {
    const bool lidar = std::any_of(rig.lidars.begin(), rig.lidars.end(),
                                   [&](const LidarConfig& config) { return config.name == name; });
    return lidar ? SensorResult::Type::kLidar : SensorResult::Type::kCamera;
  };
  for (const QualityCheck& check : result->checks) {
    if (check.Passed() || check.failure.empty()) continue;
    const std::string line = check.failure + "; " + check.remedy;
    if (!check.refuses) {
      result->warnings.push_back(line);
    } else if (check.sensor.empty()) {
      result->reasons.push_back(line);
    } else {
      result->rejected.push_back({check.sensor, type_of(check.sensor), line});
    }
  }
}

void GiveReasonsOfRejected(CalibrationResult* result) {
  for (const RejectedSensor& rejected : result->rejected) result->reasons.push_back(rejected.reason);
}

// Reasons against the whole, those of the rejected sensors, and what often follows from these: that the IMU
// contradicts the trajectory. Returns whether there is any against the whole.
bool GiveReasons(const Rig& rig, const Dataset& dataset, const Adjustment& adjustment,
                 CalibrationResult* result) {
  JudgeChecks(rig, result);
  const bool refused = !result->reasons.empty();
  GiveReasonsOfRejected(result);
  const std::size_t before = result->reasons.size();
  JudgeImuAgreement(dataset, adjustment, result);
  return refused || result->reasons.size() > before;
}

// From LiDARs of the rig to those that are given; points of others are dropped.
void RenumberLidars(const std::vector<bool>& shown, std::vector<MapPoint>* map) {
  std::vector<int> places;
  int next = 0;
  for (const bool given : shown) places.push_back(given ? next++ : -1);
  for (MapPoint& point : *map) point.lidar = places[point.lidar];
  map->erase(std::remove_if(map->begin(), map->end(), [](const MapPoint& point) { return point.lidar < 0; }),
             map->end());
}

// By the check of this name; empty: by any.
bool IsRefused(const std::string& sensor, const std::vector<QualityCheck>& checks,
               const std::string& name = "") {
  return std::any_of(checks.begin(), checks.end(), [&](const QualityCheck& check) {
    return check.sensor == sensor && check.refuses && !check.Passed() && (name.empty() || check.name == name);
  });
}

// Of the sensors that took part.
std::vector<SensorHalves> HalvesOf(const Adjustment& adjustment, const std::vector<Sensor>& sensors,
                                   const std::vector<bool>& taking_part) {
  std::vector<SensorHalves> halves;
  for (std::size_t s = 0; s < adjustment.halves.size(); ++s) {
    if (!taking_part[s] || adjustment.halves[s].quantities.empty()) continue;
    halves.push_back(adjustment.halves[s]);
    halves.back().sensor = sensors[s].name;
  }
  return halves;
}

// Every pair whose sensors are shown, and those that their own data tie to each other. lost: of each sensor,
// its place rests on nothing.
std::vector<PairResult> MakePairs(const std::vector<Sensor>& sensors, const std::vector<bool>& shown,
                                  const std::vector<bool>& lost, const Shown& of_data) {
  std::vector<PairResult> pairs;
  for (std::size_t a = 0; a < sensors.size(); ++a) {
    for (std::size_t b = a + 1; b < sensors.size(); ++b) {
      if (lost[a] || lost[b]) continue;
      const auto sigmas = [&](const Eigen::MatrixXd& from) {
        return MakePair(sensors[a].calibration, sensors[b].calibration, JointCovariance(from, a, b));
      };
      const PoseSigma from_data = sigmas(of_data.analysis.data_covariance).sigma;
      const bool pair_shown = from_data.translation.maxCoeff() < kTranslationLimit &&
                              from_data.rotation.maxCoeff() < kRotationLimit;
      if (!pair_shown && !(shown[a] && shown[b])) continue;
      PairResult pair = sigmas(of_data.analysis.covariance);
      pair.bound = sigmas(of_data.bound.covariance).sigma;
      pair.a = sensors[a].name;
      pair.b = sensors[b].name;
      pairs.push_back(pair);
    }
  }
  return pairs;
}

}  // namespace

std::vector<GuessedPose> GuessesOf(const Rig& rig) {
  std::vector<GuessedPose> guesses;
  const auto add = [&](const auto& sensors) {
    for (const auto& sensor : sensors) {
      if (sensor.guess) guesses.push_back({sensor.name, sensor.guess->T_imu_sensor});
    }
  };
  add(rig.lidars);
  add(rig.cameras);
  return guesses;
}

void FinishRefused(CalibrationResult* result) {
  result->verdict = Verdict::kRefused;
  GiveReasonsOfRejected(result);
  result->peak_memory_megabytes = PeakMemoryMegabytes();
}

void AssembleResult(const Rig& rig, const Dataset& dataset, const Adjustment& adjustment,
                    CalibrationResult* result) {
  const CalibrationState& state = adjustment.state;
  Check(IsFinite(state), "the calibration holds what is not a number; please report this with the log");
  Shown of_data{Analyze(adjustment, dataset), AnalyzeBound(adjustment)};
  ObservabilityAnalysis& analysis = of_data.analysis;
  ReportAsHeld(adjustment.shown_before_hold, &analysis);
  InflateTimesFromAzimuth(dataset, &analysis);
  const std::vector<Sensor> sensors = AllSensors(rig, state);
  const SensorOrder order = state.Sensors();
  const std::vector<bool>& found = adjustment.cameras.found;
  std::vector<bool> lost, taking_part;
  for (std::size_t s = 0; s < sensors.size(); ++s) {
    const SensorId id = order.At(s);
    lost.push_back(id.IsLidar() ? adjustment.rejected_lidars[id.index] || DoesNotFit(adjustment, id.index)
                                : !found[id.index]);
    taking_part.push_back(!lost[s]);
    if (!id.IsLidar() || !lost[s]) continue;
    const LidarConfig& config = rig.lidars[id.index];
    const bool loose = adjustment.loose_lidars[id.index];
    result->rejected.push_back(
        {sensors[s].name, SensorResult::Type::kLidar, loose ? WhyLoose(config) : WhyRejected(config)});
  }
  result->residuals = SummarizeResiduals(rig, dataset, adjustment);
  result->checks = MakeChecks(rig, dataset, adjustment, analysis, taking_part, result->residuals);
  result->halves = HalvesOf(adjustment, sensors, taking_part);
  const bool refused = GiveReasons(rig, dataset, adjustment, result);
  WarnOfMovement(adjustment.rounds.unsettled, &result->warnings);
  const Layout layout(state, adjustment.problem.estimate_imu_matrices);
  WarnOfLag(state.accelerometer_lag, std::sqrt(analysis.whole_covariance(layout.lag, layout.lag)),
            &result->warnings);
  std::vector<bool> shown;
  const bool drifting = ClocksDrift(state, adjustment.problem.estimate_imu_matrices, analysis);
  for (std::size_t s = 0; s < sensors.size(); ++s) {
    shown.push_back(!lost[s] && !IsRefused(sensors[s].name, result->checks));
    // What does not stay where it is has no place to the others either.
    if (IsRefused(sensors[s].name, result->checks, "halves")) lost[s] = true;
    if (!shown[s]) continue;
    result->sensors.push_back(MakeSensor(sensors[s], of_data, s, drifting));
    SensorResult& sensor = result->sensors.back();
    sensor.clock_reference = TimeFrom(dataset.drives[0].epoch, state.drives[0].trajectory.Middle());
    const SensorId id = order.At(s);
    if (id.IsLidar()) {
      sensor.corrections = CorrectionsOf(state, id.index);
      WarnOfDrift(sensor, &result->warnings);
      continue;
    }
    const std::size_t c = id.index;
    AddIntrinsics(state.cameras[c], analysis.cameras[c], &sensor);
    AddAlikeLenses(adjustment, c, &sensor);
    WarnOfDrift(sensor, &result->warnings);
    WarnOfWander(sensor, StampWander(adjustment, c), &result->warnings);
    const std::vector<HeldOutMatches>& held_out = adjustment.map.held_out_errors;
    if (c < held_out.size() && held_out[c].count > 0) sensor.held_out = held_out[c];
  }
  result->verdict = refused || result->sensors.empty() ? Verdict::kRefused
                    : result->rejected.empty()         ? Verdict::kTrusted
                                                       : Verdict::kPartial;
  result->guesses = GuessesOf(rig);
  result->initial_sensors = InitialSensors(rig, adjustment.initial, shown);
  result->pairs = MakePairs(sensors, shown, lost, of_data);
  result->rounds = adjustment.rounds.history;
  result->imu = state.MeanImu(0);
  result->gravity = state.Gravity();
  result->alignment = AlignmentOf(adjustment);
  for (std::size_t d = 0; d < state.drives.size(); ++d) {
    const SplitSpline& trajectory = state.drives[d].trajectory;
    result->trajectories.push_back(
        SampleTrajectory(dataset.drives[d], trajectory, MapOrigin(trajectory), 0.01));
  }
  result->map =
      SampleMap(state, adjustment.problem.drives[0].planes, MapOrigin(state.drives[0].trajectory), 2000000);
  RenumberLidars(shown, &result->map);
  AddSigmasInUse(rig, state, analysis, result);
  if (result->Usable()) {
    result->ground = FindPoseOverGround(result->trajectories[0], result->map, result->sensors);
  }
  for (std::size_t c = 0; c < state.cameras.size(); ++c) {
    auto projection = ProjectOnPhoto(rig, dataset, adjustment, c);
    if (projection) result->projections.push_back(std::move(*projection));
  }
  result->views = ChooseViews(rig, dataset.drives[0], state, adjustment.problem.drives[0].landmarks);
  result->keyframes = UsedKeyframes(rig, dataset, adjustment.problem.drives);
  result->peak_memory_megabytes = PeakMemoryMegabytes();
}

}  // namespace mlic
