#pragma once

#include <optional>
#include <vector>

#include "mlic_core/ingest/stamped_imu.h"

namespace mlic {

// When an IMU that measures evenly did so, where its stamps were taken on arrival.
struct EvenStamps {
  std::vector<TimeNs> stamps;  // of each sample; those that do not count have that of the one before
  double late = 0.0;           // s, rms of what the given stamps are off these
  double latest = 0.0;         // s, the most
};

// samples: in order of recording, in which arrival leaves them. Stamps that the host took, or a driver that
// polls, scatter about those of the device: by milliseconds, and after a busy moment several samples come at
// once. Samples are counted (messages that were lost leave a step of whole periods) and lines of stamp
// against count laid through two seconds of them at a time, by least absolute values; the delay that all
// share stays in the stamps, as part of the time offset. Taken where the readings are smoother at such times
// than at the given ones: a device that measures unevenly and says when is better left alone. nullopt where
// that is not shown, where the given stamps are even already, or where messages are lost too often to be
// counted.
std::optional<EvenStamps> FindEvenStamps(const std::vector<StampedImu>& samples);

}  // namespace mlic
