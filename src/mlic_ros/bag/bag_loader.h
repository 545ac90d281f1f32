#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "mlic_core/common/progress.h"
#include "mlic_core/sensors/measurements.h"
#include "mlic_core/sensors/rig.h"

namespace mlic {

struct LoadOptions {
  double start = 0.0;              // s after the first message of the earliest bag; from: structural
  std::optional<double> duration;  // s; until the end when absent
  // Of drives that are longer than a calibration takes (inspection/cost.h), the parts that show it best.
  bool most_telling = false;
  std::filesystem::path rig_directory;  // what the rig's mask files are relative to
};

// What was found, chosen and left out, in plain words for log and report; frames as the messages name them.
struct LoadReport {
  std::vector<std::string> lines;
  std::vector<std::string> warnings;
  std::string imu_frame_id;
  std::vector<std::string> lidar_frame_ids;   // in the rig's order
  std::vector<std::string> camera_frame_ids;  // in the rig's order
};

// Reads IMU, LiDARs and cameras of the rig from the bags (topics with or without the slash before them), in
// one pass and with bounded memory besides the result: messages are read in turn while the ones before are
// decoded and thinned out in parallel. Images are indexed and stay in the bags, which stay open for as long
// as the dataset's images live. Bags that overlap in time are one drive, disjoint ones are several. The
// result does not depend on the number of threads. Throws UnusableSensor where what a LiDAR or camera
// recorded cannot be used, InputError for all else that cannot, Cancelled when the token is set.
Dataset LoadDataset(const Rig& rig, const std::vector<std::filesystem::path>& bags,
                    const LoadOptions& options, LoadReport& report, const CancellationToken& cancellation,
                    ProgressSink& progress);

// The rig with the frames that it leaves open taken from the messages.
Rig WithMessageFrames(Rig rig, const LoadReport& report);

}  // namespace mlic
