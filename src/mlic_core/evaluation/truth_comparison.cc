#include "mlic_core/evaluation/truth_comparison.h"

#include <cmath>
#include <cstdio>
#include <limits>

#include "mlic_core/common/angles.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/sensors/imu_matrices.h"

namespace mlic {
namespace {

double Normalised(double error, double sigma) {
  return sigma > 0.0 ? error / sigma : std::numeric_limits<double>::quiet_NaN();
}

PoseError ErrorOf(const std::string& name, const RigidTransform& estimate, const RigidTransform& truth,
                  const PoseSigma& sigma) {
  PoseError error;
  error.name = name;
  error.translation = estimate.translation - truth.translation;
  error.rotation = Log(Eigen::Quaterniond(estimate.rotation * truth.rotation.conjugate()).normalized());
  for (int k = 0; k < 3; ++k) {
    error.normalised_translation[k] = Normalised(error.translation[k], sigma.translation[k]);
    error.normalised_rotation[k] = Normalised(error.rotation[k], sigma.rotation[k]);
  }
  error.normalised_time_offset = std::numeric_limits<double>::quiet_NaN();
  return error;
}

// Of the truth, where the result's offset holds: clocks that drift have it at one time only.
double TrueOffset(const SensorResult& truth, const SensorResult& result) {
  if (!truth.calibration.clock_drift || !result.calibration.clock_drift) return truth.calibration.time_offset;
  return truth.calibration.time_offset +
         *truth.calibration.clock_drift * SecondsSince(truth.clock_reference, result.clock_reference);
}

double OffsetError(const SensorResult& result, const SensorResult& truth) {
  return result.calibration.time_offset - TrueOffset(truth, result);
}

// Root mean square of the numbers among them; NaN without any.
double RootMeanSquare(const Eigen::Vector3d& v) {
  double sum = 0.0;
  int count = 0;
  for (int k = 0; k < 3; ++k) {
    if (std::isnan(v[k])) continue;
    sum += v[k] * v[k];
    ++count;
  }
  return count > 0 ? std::sqrt(sum / count) : std::numeric_limits<double>::quiet_NaN();
}

// Right-aligned; a dash where there is no number.
std::string Column(double value, int width, int decimals) {
  char text[64];
  if (std::isnan(value)) {
    std::snprintf(text, sizeof(text), " %*s", width, "-");
  } else {
    std::snprintf(text, sizeof(text), " %*.*f", width, decimals, value);
  }
  return text;
}

std::string TableLine(const PoseError& error) {
  std::string line = error.name + std::string(error.name.size() < 28 ? 28 - error.name.size() : 0, ' ');
  line += Column(error.RotationDegrees(), 9, 4);
  for (int k = 0; k < 3; ++k) {
    line += Column(1e3 * error.translation[k], 9, 2);
    line += error.translation_observable[static_cast<std::size_t>(k)] ? ' ' : '*';
  }
  line += Column(1e3 * error.translation.norm(), 9, 2);
  line += Column(error.time_offset ? 1e3 * *error.time_offset : std::nan(""), 10, 4);
  line += Column(RootMeanSquare(error.normalised_rotation), 8, 2);
  line += Column(RootMeanSquare(error.normalised_translation), 8, 2);
  return line + Column(std::abs(error.normalised_time_offset), 8, 2) + "\n";
}

std::string CsvLine(const char* kind, const PoseError& e) {
  const Eigen::Vector3d degrees = kDegreesPerRadian * e.rotation;
  const double values[] = {degrees.norm(),
                           degrees.x(),
                           degrees.y(),
                           degrees.z(),
                           e.translation.norm(),
                           e.translation.x(),
                           e.translation.y(),
                           e.translation.z(),
                           e.time_offset ? *e.time_offset : std::nan(""),
                           e.normalised_rotation.x(),
                           e.normalised_rotation.y(),
                           e.normalised_rotation.z(),
                           e.normalised_translation.x(),
                           e.normalised_translation.y(),
                           e.normalised_translation.z(),
                           e.normalised_time_offset};
  std::string line = std::string(kind) + "," + e.name;
  for (const double value : values) {
    char text[32];
    std::snprintf(text, sizeof(text), ",%.9g", value);
    // The sign of a NaN depends on the compiler.
    line += std::isnan(value) ? ",nan" : text;
  }
  return line + "\n";
}

}  // namespace

const SensorResult* FindSensor(const CalibrationResult& result, const std::string& name) {
  for (const SensorResult& sensor : result.sensors) {
    if (sensor.name == name) return &sensor;
  }
  return nullptr;
}

std::vector<PairResult> PairsOf(const CalibrationResult& result) {
  if (!result.pairs.empty()) return result.pairs;
  std::vector<PairResult> pairs;
  for (std::size_t a = 0; a < result.sensors.size(); ++a) {
    for (std::size_t b = a + 1; b < result.sensors.size(); ++b) {
      const SensorResult &first = result.sensors[a], &second = result.sensors[b];
      pairs.push_back({first.name, second.name,
                       first.calibration.T_imu_sensor.Inverse() * second.calibration.T_imu_sensor,
                       PoseSigma()});
    }
  }
  return pairs;
}

double PoseError::RotationDegrees() const { return kDegreesPerRadian * rotation.norm(); }

CalibrationResult InAxesOf(const CalibrationResult& result, const CalibrationResult& truth) {
  CalibrationResult turned = truth;
  if (!result.alignment) return turned;
  // The result's axes are mostly the gyroscope's: first the truth's sensors are expressed in these.
  const Eigen::Matrix3d to_gyroscope = SplitGyroscopeMatrix(truth.imu.gyroscope_matrix).rotation;
  // What the result does not have of the accelerometer's rotation to them.
  const Eigen::Matrix3d found = SplitAccelerometerMatrix(result.imu.accelerometer_matrix).rotation;
  const Eigen::Matrix3d of_truth =
      SplitAccelerometerMatrix(truth.imu.accelerometer_matrix * to_gyroscope.transpose()).rotation;
  const Eigen::Quaterniond twist =
      TwistAbout(ProjectorOn(result.alignment->of_accelerometer), found.transpose() * of_truth);
  const Eigen::Quaterniond turn = twist * Eigen::Quaterniond(to_gyroscope);
  for (SensorResult& sensor : turned.sensors) {
    RigidTransform& T = sensor.calibration.T_imu_sensor;
    T = {turn * T.rotation, turn * T.translation};
  }
  return turned;
}

TruthComparison CompareWithTruth(const CalibrationResult& result, const CalibrationResult& given_truth) {
  const CalibrationResult truth = InAxesOf(result, given_truth);
  TruthComparison comparison;
  for (const SensorResult& sensor : result.sensors) {
    const SensorResult* true_sensor = FindSensor(truth, sensor.name);
    if (true_sensor == nullptr) continue;
    PoseError error = ErrorOf(sensor.name, sensor.calibration.T_imu_sensor,
                              true_sensor->calibration.T_imu_sensor, sensor.sigma);
    error.time_offset = OffsetError(sensor, *true_sensor);
    error.normalised_time_offset = Normalised(*error.time_offset, sensor.sigma.time_offset);
    error.translation_observable = sensor.translation_observable;
    comparison.sensors.push_back(error);
  }
  for (const PairResult& pair : PairsOf(result)) {
    const SensorResult *true_a = FindSensor(truth, pair.a), *true_b = FindSensor(truth, pair.b);
    if (true_a == nullptr || true_b == nullptr) continue;
    const RigidTransform true_T_a_b =
        true_a->calibration.T_imu_sensor.Inverse() * true_b->calibration.T_imu_sensor;
    PoseError error = ErrorOf(pair.a + "/" + pair.b, pair.T_a_b, true_T_a_b, pair.sigma);
    const SensorResult *a = FindSensor(result, pair.a), *b = FindSensor(result, pair.b);
    if (a != nullptr && b != nullptr) {
      error.time_offset = OffsetError(*b, *true_b) - OffsetError(*a, *true_a);
      error.normalised_time_offset = Normalised(*error.time_offset, pair.sigma.time_offset);
    }
    comparison.pairs.push_back(error);
  }
  for (const SensorResult& sensor : truth.sensors) {
    if (FindSensor(result, sensor.name) == nullptr) comparison.not_estimated.push_back(sensor.name);
  }
  return comparison;
}

std::string TableOf(const TruthComparison& comparison, const char* title) {
  char header[300];
  std::snprintf(header, sizeof(header), "%-28s %9s %9s  %9s  %9s  %9s %10s %8s %8s %8s\n", title, "rot deg",
                "x mm", "y mm", "z mm", "|t| mm", "offset ms", "rot/s", "t/s", "offs/s");
  std::string table = header;
  for (const PoseError& error : comparison.sensors) table += TableLine(error);
  for (const PoseError& error : comparison.pairs) table += TableLine(error);
  for (const std::string& name : comparison.not_estimated) table += name + ": not calibrated\n";
  return table +
         "x/s: root mean square over claimed sigma; *: unobservable direction, decided by the guess\n";
}

std::string CsvOf(const TruthComparison& comparison) {
  std::string csv =
      "kind,name,rotation_deg,rotation_x_deg,rotation_y_deg,rotation_z_deg,translation,translation_x,"
      "translation_y,"
      "translation_z,time_offset,normalised_rotation_x,normalised_rotation_y,normalised_rotation_z,"
      "normalised_translation_x,normalised_translation_y,normalised_translation_z,normalised_time_offset\n";
  for (const PoseError& error : comparison.sensors) csv += CsvLine("sensor", error);
  for (const PoseError& error : comparison.pairs) csv += CsvLine("pair", error);
  return csv;
}

}  // namespace mlic
