#pragma once

#include <string>
#include <vector>

#include "mlic_core/ingest/stamped_imu.h"
#include "mlic_core/inspection/finding.h"
#include "mlic_core/sensors/measurements.h"

namespace mlic {

// Values that are not finite, units, gravity, spikes, readings that hang, single axes that hang, saturation.
// Places are seconds after `begin` on the recorder's clock. samples: in order of recording.
Findings ImuFindings(const std::string& name, std::vector<StampedImu> samples, TimeNs begin);

struct UsableImuSamples {
  TimeNs epoch = 0;                // stamp of the first
  std::vector<ImuSample> samples;  // time: seconds since the epoch
};

// The samples that can be used, in order of time, of the longest part without a jump of the clock that the
// loader cuts at; none where the units are wrong or nothing is finite. samples: in order of recording.
UsableImuSamples UsableImu(std::vector<StampedImu> samples);

}  // namespace mlic
