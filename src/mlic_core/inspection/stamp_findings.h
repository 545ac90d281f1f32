#pragma once

#include <string>
#include <vector>

#include "mlic_core/common/time.h"
#include "mlic_core/ingest/clock_fit.h"
#include "mlic_core/ingest/stamp_check.h"
#include "mlic_core/inspection/finding.h"

namespace mlic {

enum class SensorKind { kImu, kLidar, kCamera };

// Stamps and recording times of one sensor's messages, in order of recording.
struct SensorTimes {
  std::string name;
  SensorKind kind = SensorKind::kLidar;
  std::vector<MessageTimes> messages;
};

// FitClock of its messages; of fewer than two, a clock whose drift is not known.
ClockFit ClockOf(const SensorTimes& sensor);

// clock: ClockOf the sensor. Rate, gaps with their places, lost, doubled and disordered messages, jumps of
// the clock, stamps on arrival. Places are seconds after `begin` on the recorder's clock, which is what
// --start counts.
Findings StampFindings(const SensorTimes& sensor, const ClockFit& clock, TimeNs begin);

// How fast the sensor's clock runs away from the IMU's, both measured against the recorder's. Nothing where
// either is not determined.
Findings DriftFindings(const SensorTimes& sensor, const ClockFit& clock, const ClockFit& imu_clock);

// The share of the IMU's time in which the sensor has messages, by stamps: late starts, early ends, clocks of
// different epochs.
Findings OverlapFindings(const SensorTimes& sensor, const SensorTimes& imu);

}  // namespace mlic
