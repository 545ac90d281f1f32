#include "mlic_core/pipeline/earlier_calibration.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "mlic_core/common/error.h"
#include "mlic_core/common/join.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/uncertainty/observability.h"

namespace mlic {
namespace {

const SensorResult* Find(const CalibrationResult& calibration, const std::string& name) {
  for (const SensorResult& sensor : calibration.sensors) {
    if (sensor.name == name) return &sensor;
  }
  return nullptr;
}

// Axes without a sigma, as those of a truth file, keep what there is.
void TakeSigma(const Eigen::Vector3d& from, Eigen::Vector3d* to) {
  for (int a = 0; a < 3; ++a) {
    if (from[a] > 0.0 && std::isfinite(from[a])) (*to)[a] = from[a];
  }
}

template <typename Config>
void TakePlace(const SensorResult& sensor, SensorResult::Type type, Config* config) {
  if (sensor.type != type) {
    throw InputError(config->name + ": a LiDAR in one of the rig file and the prior, a camera in the other");
  }
  config->guess = ExtrinsicGuess();
  config->guess->T_imu_sensor = sensor.calibration.T_imu_sensor;
  TakeSigma(sensor.sigma.translation, &config->guess->sigma_translation);
  TakeSigma(sensor.sigma.rotation, &config->guess->sigma_rotation);
  if (!std::isnan(sensor.sigma.time_offset)) config->time_offset = sensor.calibration.time_offset;
  if (!config->fixed) return;
  config->held_sigma = HeldSigma();
  TakeSigma(sensor.sigma.translation, &config->held_sigma->translation);
  TakeSigma(sensor.sigma.rotation, &config->held_sigma->rotation);
  if (sensor.sigma.time_offset > 0.0) config->held_sigma->time_offset = sensor.sigma.time_offset;
}

void TakeLens(const SensorResult& sensor, CameraConfig* config) {
  if (!sensor.intrinsics) return;
  if (sensor.intrinsics->model != config->model) {
    throw InputError(config->name +
                     ": the prior has it with another camera model than the rig file; give the prior's model "
                     "in the rig file");
  }
  config->intrinsics = sensor.intrinsics->parameters;
}

// Calls visit(place, sensor) for every sensor of the rig that the calibration has; says which it has not.
template <typename Visitor>
void ForEachKnown(const CalibrationResult& earlier, Rig* rig, std::vector<std::string>* lacking,
                  const Visitor& visit) {
  const auto of = [&](auto& configs) {
    for (auto& config : configs) {
      const SensorResult* sensor = Find(earlier, config.name);
      if (sensor == nullptr) {
        lacking->push_back(config.name);
      } else {
        visit(*sensor, &config);
      }
    }
  };
  of(rig->lidars);
  of(rig->cameras);
}

bool Has(const Rig& rig, const std::string& name) {
  const auto has = [&](const auto& configs) {
    return std::any_of(configs.begin(), configs.end(),
                       [&](const auto& config) { return config.name == name; });
  };
  return has(rig.lidars) || has(rig.cameras);
}

struct TakeFromEarlier {
  void operator()(const SensorResult& sensor, LidarConfig* config) const {
    TakePlace(sensor, SensorResult::Type::kLidar, config);
  }
  void operator()(const SensorResult& sensor, CameraConfig* config) const {
    TakePlace(sensor, SensorResult::Type::kCamera, config);
    TakeLens(sensor, config);
  }
};

void CheckUsable(const CalibrationResult& earlier) {
  if (!earlier.Usable()) throw InputError("the prior was refused; give a calibration that is trusted");
  if (!earlier.root.empty()) {
    throw InputError("the prior has pairs of sensors only, which nothing ties to the IMU");
  }
}

void NoteOthers(const Rig& rig, const CalibrationResult& earlier, std::vector<std::string>* notes) {
  for (const SensorResult& sensor : earlier.sensors) {
    if (!Has(rig, sensor.name)) notes->push_back(sensor.name + ": the prior has it, the rig file has not");
  }
}

// Of T_imu_sensor when it moves with another sensor that is off: both rotations alike, and the arm turns.
PoseSigma CarriedSigma(const SensorResult& held, const SensorResult& sensor) {
  const Eigen::Matrix3d arm =
      Hat(sensor.calibration.T_imu_sensor.translation - held.calibration.T_imu_sensor.translation);
  const Eigen::Vector3d of_arm = arm.cwiseAbs2() * held.sigma.rotation.cwiseAbs2();
  PoseSigma sigma = held.sigma;
  sigma.translation = (held.sigma.translation.cwiseAbs2() + of_arm).cwiseSqrt();
  return sigma;
}

Eigen::Matrix<double, 14, 14> Independent(const PoseSigma& a, const PoseSigma& b) {
  Eigen::Matrix<double, 14, 1> sigmas;
  sigmas << a.rotation, a.translation, a.time_offset, b.rotation, b.translation, b.time_offset;
  return sigmas.cwiseAbs2().asDiagonal();
}

void TakePair(const CalibrationResult& earlier, PairResult* pair) {
  const SensorResult *a = Find(earlier, pair->a), *b = Find(earlier, pair->b);
  for (const PairResult& known : earlier.pairs) {
    if (known.a == pair->a && known.b == pair->b) return void(*pair = known);
  }
  pair->sigma = MakePair(a->calibration, b->calibration, Independent(a->sigma, b->sigma)).sigma;
  pair->in_use.clear();
}

void TakeQuality(const SensorResult& earlier, SensorResult* sensor) {
  sensor->sigma = earlier.sigma;
  sensor->translation_observable = earlier.translation_observable;
  sensor->rotation_observable = earlier.rotation_observable;
  sensor->time_offset_observable = earlier.time_offset_observable;
  sensor->unobservable = earlier.unobservable;
  sensor->in_use = earlier.in_use;
  if (!earlier.intrinsics) return;  // the lens is none of what is held
  sensor->intrinsics_sigma = earlier.intrinsics_sigma;
  sensor->intrinsics_fixed = earlier.intrinsics_fixed;
  if (sensor->readout_sigma) sensor->readout_sigma = earlier.readout_sigma;
}

void Combine(const PoseSigma& largest, PoseSigma* sigma) {
  sigma->rotation = (sigma->rotation.cwiseAbs2() + largest.rotation.cwiseAbs2()).cwiseSqrt();
  sigma->translation = (sigma->translation.cwiseAbs2() + largest.translation.cwiseAbs2()).cwiseSqrt();
  sigma->time_offset = std::hypot(sigma->time_offset, largest.time_offset);
}

void TakeLarger(const PoseSigma& sigma, PoseSigma* largest) {
  largest->rotation = largest->rotation.cwiseMax(sigma.rotation);
  largest->translation = largest->translation.cwiseMax(sigma.translation);
  largest->time_offset = std::max(largest->time_offset, sigma.time_offset);
}

// By what a sensor is off against a held one when it follows the other held ones: the largest of these pairs,
// in all directions alike.
PoseSigma LargestOfPairs(const CalibrationResult& result, const std::string& held,
                         const SensorResult& sensor) {
  PoseSigma largest;
  for (const PairResult& pair : result.pairs) {
    if (pair.a != held && pair.b != held) continue;
    const SensorResult* other = Find(result, pair.a == held ? pair.b : pair.a);
    if (other == nullptr || !other->fixed) continue;
    const double arm =
        (sensor.calibration.T_imu_sensor.translation - other->calibration.T_imu_sensor.translation).norm();
    PoseSigma carried = pair.sigma;
    carried.rotation.setConstant(pair.sigma.rotation.maxCoeff());
    carried.translation.setConstant(std::hypot(pair.sigma.translation.maxCoeff(), carried.rotation[0] * arm));
    TakeLarger(carried, &largest);
  }
  return largest;
}

Rig InAxesOfEarlier(const Rig& rig, const CalibrationResult& earlier) {
  Rig start = rig;
  if (earlier.alignment) start.imu.accelerometer_axes = earlier.alignment->of_accelerometer;
  return start;
}

}  // namespace

Rig WithPrior(const Rig& rig, const CalibrationResult& earlier, std::vector<std::string>* notes) {
  CheckUsable(earlier);
  Rig start = InAxesOfEarlier(rig, earlier);
  std::vector<std::string> lacking;
  std::vector<ExtrinsicGuess*> guesses;
  bool any = false;
  ForEachKnown(earlier, &start, &lacking, [&](const SensorResult& sensor, auto* config) {
    TakeFromEarlier()(sensor, config);
    any = true;
    if (!config->fixed) guesses.push_back(&*config->guess);
  });
  if (!any) throw InputError("the prior has no sensor of the rig file: their names are compared");
  const double factor = std::sqrt(static_cast<double>(guesses.size()));
  for (ExtrinsicGuess* guess : guesses) {
    guess->sigma_translation *= factor;
    guess->sigma_rotation *= factor;
  }
  for (const std::string& name : lacking) {
    notes->push_back(name + ": not in the prior, it starts as the rig file says");
  }
  NoteOthers(rig, earlier, notes);
  return start;
}

Rig WithAddedSensors(const Rig& rig, const CalibrationResult& earlier, const std::vector<std::string>& added,
                     std::vector<std::string>* notes) {
  CheckUsable(earlier);
  const auto is_added = [&](const std::string& name) {
    return std::find(added.begin(), added.end(), name) != added.end();
  };
  for (const std::string& name : added) {
    if (!Has(rig, name)) throw InputError("--add " + name + ": the rig file has no such sensor");
  }
  Rig start = InAxesOfEarlier(rig, earlier);
  std::vector<std::string> lacking;
  bool any = false;
  ForEachKnown(earlier, &start, &lacking, [&](const SensorResult& sensor, auto* config) {
    if (is_added(config->name)) return;
    TakeFromEarlier()(sensor, config);
    config->fixed = any = true;
    if (!sensor.calibration.clock_drift) return;
    notes->push_back(config->name +
                     ": its clock drifted when it was calibrated, so that its time offset may not hold here");
  });
  lacking.erase(std::remove_if(lacking.begin(), lacking.end(), is_added), lacking.end());
  if (!lacking.empty()) {
    throw InputError("the prior lacks " + Joined(lacking, ", ") +
                     "; give --add for it too, or enabled: false in the rig file");
  }
  if (!any) throw InputError("--add: no sensor is left that is held where the prior has it");
  NoteOthers(rig, earlier, notes);
  return start;
}

CalibrationResult HeldSensors(const Rig& rig) {
  CalibrationResult held;
  const auto add = [&](const auto& configs) {
    for (const auto& config : configs) {
      if (!config.fixed || !config.held_sigma) continue;
      SensorResult sensor;
      sensor.name = config.name;
      sensor.calibration.T_imu_sensor = config.guess->T_imu_sensor;
      sensor.sigma = {config.held_sigma->translation, config.held_sigma->rotation,
                      config.held_sigma->time_offset};
      held.sensors.push_back(sensor);
    }
  };
  add(rig.lidars);
  add(rig.cameras);
  return held;
}

void AddSigmasOfHeld(const CalibrationResult& earlier, CalibrationResult* result) {
  const auto is_held = [&](const SensorResult& sensor) {
    return sensor.fixed && Find(earlier, sensor.name) != nullptr;
  };
  for (SensorResult& sensor : result->sensors) {
    if (is_held(sensor)) TakeQuality(*Find(earlier, sensor.name), &sensor);
  }
  std::map<std::string, PoseSigma> own;  // against the held sensors
  for (SensorResult& sensor : result->sensors) {
    if (sensor.fixed) continue;
    own[sensor.name] = sensor.sigma;
    PoseSigma largest;
    for (const SensorResult& held : result->sensors) {
      if (is_held(held)) TakeLarger(CarriedSigma(held, sensor), &largest);
    }
    Combine(largest, &sensor.sigma);
    sensor.in_use.clear();  // of this drive alone
  }
  const auto held = [&](const std::string& name) {
    const SensorResult* sensor = Find(*result, name);
    return sensor != nullptr && is_held(*sensor);
  };
  for (PairResult& pair : result->pairs) {
    if (held(pair.a) && held(pair.b)) TakePair(earlier, &pair);
  }
  for (PairResult& pair : result->pairs) {
    if (held(pair.a) == held(pair.b)) continue;
    const std::string &fixed = held(pair.a) ? pair.a : pair.b, &other = held(pair.a) ? pair.b : pair.a;
    const SensorResult *a = Find(*result, pair.a), *b = Find(*result, pair.b);
    if (a == nullptr || b == nullptr) continue;
    const PoseSigma known;
    pair.sigma = MakePair(a->calibration, b->calibration,
                          Independent(held(pair.a) ? known : own[pair.a], held(pair.b) ? known : own[pair.b]))
                     .sigma;
    Combine(LargestOfPairs(*result, fixed, *Find(*result, other)), &pair.sigma);
    pair.in_use.clear();
  }
}

}  // namespace mlic
