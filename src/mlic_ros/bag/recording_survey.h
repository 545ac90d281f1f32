#pragma once

#include <string>
#include <vector>

#include "mlic_core/common/progress.h"
#include "mlic_core/ingest/stamped_imu.h"
#include "mlic_core/inspection/camera_findings.h"
#include "mlic_core/inspection/lidar_findings.h"
#include "mlic_core/inspection/stamp_findings.h"
#include "mlic_core/sensors/rig.h"
#include "mlic_ros/bag/bag_set.h"

namespace mlic {

// What the doctor looks at in one drive: of every message its stamps, of the IMU its readings, of LiDARs and
// cameras a sparse sample.
struct RecordingSurvey {
  BagSet::Interval interval;
  std::vector<StampedImu> imu;  // in order of recording
  SensorTimes imu_times;
  std::string imu_frame;
  // In the rig's order.
  std::vector<LidarSurvey> lidars;
  std::vector<SensorTimes> lidar_times;
  std::vector<std::string> lidar_frames;
  std::vector<CameraSurvey> cameras;
  std::vector<SensorTimes> camera_times;
  std::vector<std::string> camera_frames;
};

// One pass over the bags with bounded memory besides the result. All topics of the rig are in the bags and of
// the right type. Throws InputError for a damaged bag, Cancelled when the token is set.
RecordingSurvey SurveyRecording(const BagSet& bags, const Rig& rig, const BagSet::Interval& interval,
                                const CancellationToken& cancellation);

// The scans of all LiDARs of the rig in the interval, thinned out; times are seconds after `epoch`. Formats:
// those of the survey; LiDARs without one have no scans.
std::vector<LidarRecording> ReadStretch(const BagSet& bags, const Rig& rig, const RecordingSurvey& survey,
                                        const BagSet::Interval& interval, TimeNs epoch,
                                        const CancellationToken& cancellation);

}  // namespace mlic
