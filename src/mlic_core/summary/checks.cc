#include "mlic_core/summary/checks.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "mlic_core/common/angles.h"
#include "mlic_core/geometry/symmetric_matrix.h"
#include "mlic_core/initialization/guess_check.h"
#include "mlic_core/sensors/observability_limits.h"
#include "mlic_core/sensors/sensor_frames.h"
#include "mlic_core/summary/camera_checks.h"
#include "mlic_core/summary/imu_verdict.h"
#include "mlic_core/uncertainty/range_corrections.h"
#include "mlic_core/uncertainty/split_halves.h"

namespace mlic {
namespace {

using Bound = QualityCheck::Bound;

// What all checks are made from.
struct Judged {
  const Rig& rig;
  const Dataset& dataset;
  const Adjustment& adjustment;
  const ObservabilityAnalysis& analysis;
  const std::vector<ResidualSummary>& residuals;
};

// A sensor's side of the rig file.
struct Given {
  std::string name;
  bool fixed = false;
  std::optional<ExtrinsicGuess> guess;
};

Given GivenOf(const Rig& rig, SensorId id) {
  if (id.IsLidar()) {
    const LidarConfig& lidar = rig.lidars[id.index];
    return {lidar.name, lidar.fixed, lidar.guess};
  }
  const CameraConfig& camera = rig.cameras[id.index];
  return {camera.name, camera.fixed, camera.guess};
}

// The last round of a run that converges moves the calibration by a tenth of its sigma at most.
QualityCheck CheckConvergence(const Adjustment& adjustment) {
  QualityCheck check;
  check.name = "convergence";
  check.value = adjustment.rounds.last_change;
  check.limit = 1.0;  // from: definition, a calibration that moves by more than its sigma has none
  check.unit = "sigma";
  check.refuses = true;
  char text[200];
  std::snprintf(
      text, sizeof(text),
      "the calibration has not converged: the last round moved it by %.3g of its sigma, the limit is "
      "%.0f",
      check.value, check.limit);
  check.failure = text;
  check.remedy = "record a longer drive, with more turns and among more structure";
  return check;
}

// With the guess, where the motion shows less than that.
bool IsRotationKnown(const ObservabilityAnalysis::Sensor& shown) {
  return std::all_of(shown.directions.begin(), shown.directions.end(), [](const UnobservableDirection& d) {
    return d.quantity != UnobservableDirection::Quantity::kRotation || d.sigma <= kRotationLimit;
  });
}

// Name of the sensor whose whole rotation the motion shows and to which that of sensor s (SensorOrder) is
// known within the limit, best of all.
std::optional<std::string> ShownBesides(const Judged& judged, std::size_t s,
                                        const std::vector<bool>& taking_part) {
  const ObservabilityAnalysis& analysis = judged.analysis;
  const CalibrationState& state = judged.adjustment.state;
  const SensorOrder order = state.Sensors();
  std::optional<std::string> best;
  double least = kRotationLimit;
  for (std::size_t o = 0; o < order.size(); ++o) {
    const ObservabilityAnalysis::LeastShown& whole = analysis.sensors[o].least_rotation;
    if (o == s || !taking_part[o] || !(whole.sigma <= whole.limit)) continue;
    const Eigen::Matrix<double, 7, 7> pair =
        PairCovariance(state.Sensor(order.At(o)), state.Sensor(order.At(s)),
                       JointCovariance(analysis.data_covariance, o, s));
    const double sigma =
        std::sqrt(SymmetricEigen<3>(Eigen::Matrix3d(pair.topLeftCorner<3, 3>())).eigenvalues()[2]);
    if (!(sigma <= least)) continue;
    least = sigma;
    best = GivenOf(judged.rig, order.At(o)).name;
  }
  return best;
}

// What the motion shows of one sensor, in the direction that it shows least in terms of its limit. besides:
// ShownBesides.
void AddExcitation(const Given& sensor, const ObservabilityAnalysis::Sensor& shown, bool guess_contradicted,
                   const std::optional<std::string>& besides, std::vector<QualityCheck>* checks) {
  const auto make = [&](const char* name, const ObservabilityAnalysis::LeastShown& least, double factor,
                        const char* unit) {
    QualityCheck check;
    check.name = name;
    check.sensor = sensor.name;
    check.value = factor * least.sigma;
    check.limit = factor * least.limit;
    check.unit = unit;
    check.refuses = true;
    return check;
  };
  QualityCheck rotation = make("excitation_rotation", shown.least_rotation, kDegreesPerRadian, "deg");
  rotation.failure = sensor.name + ": the motion does not show its whole rotation to 0.5 deg";
  rotation.remedy = "turn about more axes";
  if (!std::isfinite(rotation.value)) {
    rotation.failure = sensor.name + ": its sigmas are not numbers, as the solve came out singular";
  } else if (sensor.guess && !guess_contradicted && IsRotationKnown(shown)) {
    rotation.refuses = false;
    rotation.failure = sensor.name + ": the motion shows its rotation less well than its guess has it, ";
    rotation.failure += "there the given T_imu_sensor, or the prior's, decides";
    rotation.remedy = "nothing is wrong where that is right; turn about more axes to see it in the data";
  } else if (besides) {
    rotation.refuses = false;
    rotation.failure = sensor.name + ": the motion shows its rotation to 0.5 deg against " + *besides +
                       " alone, not against the IMU";
  }
  QualityCheck offset = make("excitation_time_offset", shown.least_time_offset, 1e3, "ms");
  offset.failure = sensor.name + ": the motion does not show its time offset to 5 ms";
  offset.remedy = "turn more, and not evenly";
  QualityCheck translation = make("excitation_translation", shown.least_translation, 1.0, "m");
  translation.remedy = "turn about more axes, or measure it by hand and give it in the rig file";
  const std::string not_shown = sensor.name + ": the motion does not show its whole translation to 5 cm, ";
  if (guess_contradicted) {
    translation.failure = not_shown + "and contradicts the given T_imu_sensor where it does";
    translation.remedy = "give the T_imu_sensor that maps points of the sensor into the IMU's frame";
  } else if (sensor.guess) {
    translation.refuses = false;
    translation.failure = not_shown + "there it stands at the given T_imu_sensor, or the prior's";
  } else {
    translation.failure = not_shown + "and the rig file gives no T_imu_sensor to fall back on";
  }
  // A wrong guess is told first: it can make the rest look badly shown.
  for (QualityCheck* check : {&translation, &rotation, &offset}) checks->push_back(*check);
}

// The sensor of its kind with which one looks exchanged, and by how many sigmas.
struct Exchange {
  std::string with;
  double sigmas = 0.0;
};

std::optional<Exchange> ExchangeOf(const Rig& rig, const CalibrationState& state, SensorId id,
                                   const std::vector<bool>& taking_part) {
  const Given sensor = GivenOf(rig, id);
  std::optional<Exchange> worst;
  if (!sensor.guess) return worst;
  const SensorOrder order = state.Sensors();
  for (std::size_t s = 0; s < order.size(); ++s) {
    const SensorId other = order.At(s);
    if (!taking_part[s] || other.IsLidar() != id.IsLidar() || other.index == id.index) continue;
    const Given there = GivenOf(rig, other);
    if (!there.guess || there.fixed) continue;
    const double sigmas = SigmasOfExchange(*sensor.guess, state.Sensor(id).T_imu_sensor, *there.guess,
                                           state.Sensor(other).T_imu_sensor);
    if (sigmas > kLooksExchanged && (!worst || sigmas > worst->sigmas)) worst = Exchange{there.name, sigmas};
  }
  return worst;
}

void AddAgreementWithGuess(const Given& sensor, const RigidTransform& found,
                           const std::optional<Exchange>& exchange, std::vector<QualityCheck>* checks) {
  if (!sensor.guess) return;
  QualityCheck check;
  check.name = "agreement_with_guess";
  check.sensor = sensor.name;
  check.value = SigmasFromGuess(*sensor.guess, found);
  check.limit = kFarFromGuess;
  check.unit = "sigma";
  check.failure = sensor.name + ": " + DescribeDistance(*sensor.guess, found);
  check.remedy = "check that T_imu_sensor maps points of the sensor into the IMU's frame, and the topic";
  if (exchange) {
    check.value = exchange->sigmas;
    check.limit = kLooksExchanged;
    check.refuses = true;
    check.failure = sensor.name + ": lies where the given T_imu_sensor of " + exchange->with +
                    " has it, and the other way round";
    check.remedy = LookExchanged(sensor.name, exchange->with);
  }
  checks->push_back(check);
}

// Scans that do not keep one time offset to the IMU.
QualityCheck CheckStamps(const std::string& name, const StampErrors& errors) {
  QualityCheck check;
  check.name = "stamps";
  check.sensor = name;
  check.value = errors.excess;
  check.limit = 4.0;  // sigmas are doubled; from: definition
  check.unit = "of the noise's variance";
  if (errors.wanders) {
    check.failure = name +
                    ": its clock does not keep step with the IMU's, it drifts or jumps within the drive; no "
                    "time offset is right for all of it";
    check.remedy = "synchronise the clocks, or cut the drive by --start and --duration";
  } else {
    char text[120];
    std::snprintf(text, sizeof(text),
                  ": its stamps jitter by %.1f ms from message to message against the IMU's",
                  1e3 * errors.jitter);
    check.failure = name + text;
    check.remedy = "let the device stamp its messages, not the host on arrival";
  }
  return check;
}

// What all ranges of a LiDAR seem to err by. offset: m.
QualityCheck CheckRanges(const std::string& name, double offset) {
  QualityCheck check;
  check.name = "ranges";
  check.sensor = name;
  check.value = std::abs(offset);
  check.limit = kLargestRangeOffset;
  check.unit = "m";
  check.refuses = true;
  check.failure = name + ": all its ranges seem wrong, by more than a LiDAR errs; part of the trajectory is";
  check.remedy = "record among more that is flat and stands still, and turn more slowly";
  return check;
}

// Sums over the map's points.
void AddPlanes(const Judged& judged, const std::vector<bool>& taking_part,
               std::vector<QualityCheck>* checks) {
  const PlaneAssociation& map = judged.adjustment.problem.drives[0].planes;
  QualityCheck count;
  count.name = "planes";
  count.value = static_cast<double>(map.planes.size());
  count.limit = 20.0;
  count.unit = "planes";
  count.bound = Bound::kLeast;
  count.refuses = true;
  count.failure = "the map has hardly any planes";
  count.remedy = "record near buildings or in a furnished hall";
  checks->push_back(count);
  const std::size_t lidars = judged.adjustment.state.lidars.size();
  std::vector<Eigen::Matrix3d> directions(lidars, Eigen::Matrix3d::Zero());
  for (std::size_t p = 0; p < map.planes.size(); ++p) {
    const Eigen::Vector3d& normal = map.planes[p].plane.normal;
    for (std::size_t k = map.begin[p]; k < map.begin[p + 1]; ++k) {
      directions[map.observations[k].lidar] += normal * normal.transpose();
    }
  }
  for (std::size_t l = 0; l < lidars; ++l) {
    if (!taking_part[l]) continue;
    const Eigen::Vector3d shares = SymmetricEigen<3>(directions[l]).eigenvalues();
    QualityCheck check;
    check.name = "coverage_directions";
    check.sensor = judged.rig.lidars[l].name;
    check.value = shares[2] > 0.0 ? std::max(0.0, shares[0]) / shares[2] : 0.0;
    check.limit = 0.01;  // a tenth in sigma
    check.unit = "of the planes' points, weakest against strongest direction";
    check.bound = Bound::kLeast;
    check.failure = check.sensor + ": its planes hardly face one direction of space";
    check.remedy = "record where the sensor sees walls that face different ways, and ground";
    checks->push_back(check);
  }
}

void AddImuAgreement(const Judged& judged, std::vector<QualityCheck>* checks) {
  QualityCheck check;
  check.name = "imu_agreement";
  check.limit = kImuContradicts;
  check.unit = "of the noise of a second's mean";
  check.refuses = true;
  for (const ImuDisagreement& found : DisagreementsOfImu(judged.dataset, judged.adjustment, 0.0)) {
    check.value = std::max(check.value, found.ratio);
  }
  check.remedy = "leave the stretch out by --start and --duration";
  checks->push_back(check);
  check.name = "imu_slow_errors";
  check.value = LargestSlowError(judged.adjustment);
  check.limit = kImuSlowErrors;
  check.unit = "of the noise of means over 1 to 10 s";
  check.remedy = "record shorter, after the IMU has warmed up, or try intrinsics: scale_misalignment";
  checks->push_back(check);
}

// Of LiDARs and cameras: whether residuals drift together over time.
void AddWhiteness(const Judged& judged, const std::string& name, std::vector<QualityCheck>* checks) {
  for (const ResidualSummary& residual : judged.residuals) {
    if (residual.sensor != name) continue;
    QualityCheck check;
    check.name = "whiteness";
    check.sensor = name;
    check.value = residual.drift;
    check.limit = 0.5;  // of a residual's own noise
    check.unit = "sigma";
    check.failure = name + ": its residuals drift over the drive";
    check.remedy = "check mount and clock, and what moves in its view";
    checks->push_back(check);
  }
}

// Whether parts of the drive give the same calibration of a sensor. limit: by chance, of all sensors'
// comparisons.
void AddHalves(const std::string& name, const SensorHalves& halves, double limit,
               std::vector<QualityCheck>* checks) {
  if (halves.quantities.empty()) return;
  QualityCheck check;
  check.name = "halves";
  check.sensor = name;
  check.value = WorstOf(halves);
  check.limit = limit;
  check.unit = "sigma";
  check.refuses = true;
  check.failure = name + ": " + NameOf(halves.parts) + " of the drive do not agree on it: they differ in " +
                  Describe(halves);
  check.remedy =
      "check that its mount, its clock and the IMU are the same all the time; record again, or only the part "
      "before";
  checks->push_back(check);
}

}  // namespace

std::vector<QualityCheck> MakeChecks(const Rig& rig, const Dataset& dataset, const Adjustment& adjustment,
                                     const ObservabilityAnalysis& analysis,
                                     const std::vector<bool>& taking_part,
                                     const std::vector<ResidualSummary>& residuals) {
  const Judged judged{rig, dataset, adjustment, analysis, residuals};
  std::vector<QualityCheck> checks{CheckConvergence(adjustment)};
  const SensorOrder order = adjustment.state.Sensors();
  const double by_chance = LargestByChance(adjustment.halves);
  for (std::size_t s = 0; s < order.size(); ++s) {
    if (!taking_part[s]) continue;
    const SensorId id = order.At(s);
    const Given sensor = GivenOf(rig, id);
    if (!sensor.fixed) {
      AddExcitation(sensor, analysis.sensors[s], adjustment.contradicted_guesses[s],
                    ShownBesides(judged, s, taking_part), &checks);
      AddAgreementWithGuess(sensor, adjustment.state.Sensor(id).T_imu_sensor,
                            ExchangeOf(rig, adjustment.state, id, taking_part), &checks);
    }
    if (s < adjustment.scale.stamps.size()) {
      checks.push_back(CheckStamps(sensor.name, adjustment.scale.stamps[s]));
    }
    AddWhiteness(judged, sensor.name, &checks);
    if (s < adjustment.halves.size()) {
      AddHalves(sensor.name, adjustment.halves[s], by_chance, &checks);
    }
    if (id.IsLidar() && id.index < adjustment.scale.offsets.size()) {
      checks.push_back(CheckRanges(sensor.name, adjustment.scale.offsets[id.index]));
    }
    if (!id.IsLidar()) {
      const std::vector<QualityCheck> of_camera =
          MakeCameraChecks(sensor.name, id.index, adjustment, residuals);
      checks.insert(checks.end(), of_camera.begin(), of_camera.end());
    }
  }
  if (!adjustment.state.lidars.empty()) AddPlanes(judged, taking_part, &checks);
  AddImuAgreement(judged, &checks);
  checks.push_back(CheckImuState(adjustment));
  return checks;
}

std::string DescribeCheck(const QualityCheck& check) {
  char text[240];
  std::snprintf(text, sizeof(text), "check %s%s%s: %.3g, at %s %.3g %s: %s", check.name.c_str(),
                check.sensor.empty() ? "" : " of ", check.sensor.c_str(), check.value,
                check.bound == Bound::kMost ? "most" : "least", check.limit, check.unit.c_str(),
                check.Passed() ? "passed" : "failed");
  return text;
}

}  // namespace mlic
