#include "mlic_core/evaluation/calibration_difference.h"

#include <cmath>
#include <cstdio>

#include "mlic_core/sensors/camera_model.h"

namespace mlic {
namespace {

void AddInQuadrature(const PoseSigma& more, PoseSigma* sigma) {
  for (int k = 0; k < 3; ++k) {
    sigma->translation[k] = std::hypot(sigma->translation[k], more.translation[k]);
    sigma->rotation[k] = std::hypot(sigma->rotation[k], more.rotation[k]);
  }
  sigma->time_offset = std::hypot(sigma->time_offset, more.time_offset);
}

CalibrationResult WithSigmasOfBoth(CalibrationResult a, const CalibrationResult& b) {
  for (SensorResult& sensor : a.sensors) {
    const SensorResult* other = FindSensor(b, sensor.name);
    if (other == nullptr) continue;
    AddInQuadrature(other->sigma, &sensor.sigma);
    for (std::size_t k = 0; k < 3; ++k) {
      sensor.translation_observable[k] = sensor.translation_observable[k] && other->translation_observable[k];
    }
  }
  for (PairResult& pair : a.pairs) {
    for (const PairResult& other : b.pairs) {
      if (other.a == pair.a && other.b == pair.b) AddInQuadrature(other.sigma, &pair.sigma);
    }
  }
  return a;
}

double SigmaOf(const std::vector<double>& sigmas, std::size_t i) {
  return i < sigmas.size() ? sigmas[i] : 0.0;
}

void AddIntrinsics(const SensorResult& a, const SensorResult& b,
                   std::vector<IntrinsicDifference>* differences) {
  if (a.rolling_shutter_readout && b.rolling_shutter_readout) {
    differences->push_back({a.name, "readout", *a.rolling_shutter_readout - *b.rolling_shutter_readout,
                            std::hypot(a.readout_sigma.value_or(0.0), b.readout_sigma.value_or(0.0))});
  }
  if (!a.intrinsics || !b.intrinsics || a.intrinsics->model != b.intrinsics->model) return;
  const std::vector<std::string> names = ParameterNames(a.intrinsics->model);
  for (std::size_t i = 0; i < names.size(); ++i) {
    differences->push_back({a.name, names[i], a.intrinsics->parameters[i] - b.intrinsics->parameters[i],
                            std::hypot(SigmaOf(a.intrinsics_sigma, i), SigmaOf(b.intrinsics_sigma, i))});
  }
}

void TakeIfLarger(const std::string& of, double sigmas, LargestDifference* largest) {
  if (std::abs(sigmas) > largest->sigmas || (largest->of.empty() && !std::isnan(sigmas))) {
    *largest = {of, std::abs(sigmas)};
  }
}

}  // namespace

CalibrationDifference Subtract(const CalibrationResult& a, const CalibrationResult& b) {
  CalibrationDifference difference;
  difference.poses = CompareWithTruth(WithSigmasOfBoth(a, b), b);
  difference.only_in_b = std::move(difference.poses.not_estimated);
  difference.poses.not_estimated.clear();
  for (const SensorResult& sensor : a.sensors) {
    const SensorResult* other = FindSensor(b, sensor.name);
    if (other == nullptr) {
      difference.only_in_a.push_back(sensor.name);
    } else {
      AddIntrinsics(sensor, *other, &difference.intrinsics);
    }
  }
  return difference;
}

LargestDifference LargestOf(const CalibrationDifference& difference) {
  LargestDifference largest;
  for (const auto* errors : {&difference.poses.sensors, &difference.poses.pairs}) {
    for (const PoseError& error : *errors) {
      for (int k = 0; k < 3; ++k) {
        const std::string axis(1, "xyz"[k]);
        TakeIfLarger(error.name + ", rotation " + axis, error.normalised_rotation[k], &largest);
        TakeIfLarger(error.name + ", translation " + axis, error.normalised_translation[k], &largest);
      }
      TakeIfLarger(error.name + ", time offset", error.normalised_time_offset, &largest);
    }
  }
  for (const IntrinsicDifference& d : difference.intrinsics) {
    if (d.sigma > 0.0) TakeIfLarger(d.camera + ", " + d.parameter, d.value / d.sigma, &largest);
  }
  return largest;
}

std::string TableOf(const CalibrationDifference& difference) {
  std::string table = TableOf(difference.poses, "A minus B");
  char line[160];
  for (const IntrinsicDifference& d : difference.intrinsics) {
    std::snprintf(line, sizeof(line), "%s %s: %.6g", d.camera.c_str(), d.parameter.c_str(), d.value);
    table += line;
    if (d.sigma > 0.0) {
      std::snprintf(line, sizeof(line), ", %.2f sigma", std::abs(d.value) / d.sigma);
      table += line;
    }
    table += "\n";
  }
  for (const std::string& name : difference.only_in_a) table += name + ": only in A\n";
  for (const std::string& name : difference.only_in_b) table += name + ": only in B\n";
  return table;
}

}  // namespace mlic
