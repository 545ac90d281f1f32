#include "mlic_core/sensors/sensor_frames.h"

namespace mlic {

std::vector<SensorFrame> FramesOf(const Rig& rig, const std::vector<std::string>& lidar_frames,
                                  const std::vector<std::string>& camera_frames) {
  std::vector<SensorFrame> frames;
  for (std::size_t i = 0; i < rig.lidars.size(); ++i) {
    frames.push_back({rig.lidars[i].name, rig.lidars[i].frame_id, lidar_frames[i]});
  }
  for (std::size_t i = 0; i < rig.cameras.size(); ++i) {
    frames.push_back({rig.cameras[i].name, rig.cameras[i].frame_id, camera_frames[i]});
  }
  return frames;
}

std::vector<std::pair<std::size_t, std::size_t>> ExchangedFrames(const std::vector<SensorFrame>& sensors) {
  std::vector<std::pair<std::size_t, std::size_t>> exchanged;
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    const SensorFrame& a = sensors[i];
    if (a.expected.empty() || a.expected == a.found) continue;
    for (std::size_t j = i + 1; j < sensors.size(); ++j) {
      const SensorFrame& b = sensors[j];
      if (a.expected == b.found && b.expected == a.found) exchanged.push_back({i, j});
    }
  }
  return exchanged;
}

std::string LookExchanged(const std::string& a, const std::string& b) {
  return "the topics of " + a + " and " + b + " look exchanged: exchange them in the rig file";
}

}  // namespace mlic
