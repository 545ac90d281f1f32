#include "mlic_core/evaluation/methods/pairwise_method.h"

#include <optional>
#include <vector>

#include "mlic_core/evaluation/truth_comparison.h"
#include "mlic_core/pipeline/adjustment_steps.h"
#include "mlic_core/pipeline/calibrator.h"
#include "mlic_core/sensors/sensor_id.h"

namespace mlic {
namespace {

// The calibration of these sensors as if the rig had no other.
CalibrationResult CalibrateAlone(const Rig& rig, const Dataset& dataset, const std::vector<SensorId>& sensors,
                                 const CancellationToken& cancellation) {
  Rig part;
  part.imu = rig.imu;
  Dataset of_part;
  for (const Drive& drive : dataset.drives) of_part.drives.push_back({drive.epoch, drive.imu, {}, {}});
  for (const SensorId sensor : sensors) {
    if (sensor.IsLidar()) {
      part.lidars.push_back(rig.lidars[sensor.index]);
    } else {
      part.cameras.push_back(rig.cameras[sensor.index]);
    }
    for (std::size_t d = 0; d < dataset.drives.size(); ++d) {
      const Drive& drive = dataset.drives[d];
      if (sensor.IsLidar()) {
        of_part.drives[d].lidars.push_back(drive.lidars[sensor.index]);
      } else {
        of_part.drives[d].cameras.push_back(drive.cameras[sensor.index]);
      }
    }
  }
  CalibrationObserver nobody;
  return Calibrate(part, of_part, cancellation, nobody);
}

// What is known of a sensor, without what the calibration claims about it.
SensorResult WithoutClaims(const SensorResult& sensor) {
  SensorResult plain;
  plain.name = sensor.name;
  plain.type = sensor.type;
  plain.frame_id = sensor.frame_id;
  plain.topic = sensor.topic;
  plain.calibration = sensor.calibration;
  plain.clock_reference = sensor.clock_reference;
  plain.intrinsics = sensor.intrinsics;
  plain.rolling_shutter_readout = sensor.rolling_shutter_readout;
  return plain;
}

// T_a_b of a calibration's sensors; none where it does not give it.
std::optional<RigidTransform> PoseBetween(const CalibrationResult& result, const std::string& a,
                                          const std::string& b) {
  const SensorResult *of_a = FindSensor(result, a), *of_b = FindSensor(result, b);
  if (of_a == nullptr || of_b == nullptr) return std::nullopt;
  return of_a->calibration.T_imu_sensor.Inverse() * of_b->calibration.T_imu_sensor;
}

}  // namespace

CalibrationResult CalibratePairwise(const Rig& rig, const Dataset& dataset,
                                    const CancellationToken& cancellation,
                                    const std::function<void(const std::string&)>& on_pair) {
  const SensorOrder order{rig.lidars.size(), rig.cameras.size()};
  const SensorId reference = order.At(0);
  const std::string name = NameOf(reference, rig);
  on_pair(name + " to the IMU");
  const CalibrationResult alone = CalibrateAlone(rig, dataset, {reference}, cancellation);
  CalibrationResult result;
  result.imu_frame_id = alone.imu_frame_id;
  result.reasons = {"pairwise calibration: for comparison, not for use"};
  result.imu = alone.imu;
  result.alignment = alone.alignment;
  const SensorResult* const of_reference = FindSensor(alone, name);
  const auto reject = [&](SensorId sensor, const std::string& reason) {
    const auto type = sensor.IsLidar() ? SensorResult::Type::kLidar : SensorResult::Type::kCamera;
    result.rejected.push_back({NameOf(sensor, rig), type, NameOf(sensor, rig) + ": " + reason});
  };
  if (of_reference == nullptr) {
    for (std::size_t s = 0; s < order.size(); ++s) reject(order.At(s), name + " is not tied to the IMU");
    return result;
  }
  result.sensors.push_back(WithoutClaims(*of_reference));
  for (std::size_t s = 1; s < order.size(); ++s) {
    const SensorId sensor = order.At(s);
    const std::string other = NameOf(sensor, rig);
    on_pair(other + " to " + name);
    const CalibrationResult pair = CalibrateAlone(rig, dataset, {reference, sensor}, cancellation);
    const auto T_reference_other = PoseBetween(pair, name, other);
    if (!T_reference_other) {
      reject(sensor, "its pair with " + name + " gives no pose");
      continue;
    }
    SensorResult chained = WithoutClaims(*FindSensor(pair, other));
    chained.calibration.T_imu_sensor = of_reference->calibration.T_imu_sensor * *T_reference_other;
    chained.calibration.time_offset +=
        of_reference->calibration.time_offset - FindSensor(pair, name)->calibration.time_offset;
    result.sensors.push_back(std::move(chained));
  }
  return result;
}

}  // namespace mlic
