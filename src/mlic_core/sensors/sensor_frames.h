#pragma once

#include <string>
#include <utility>
#include <vector>

#include "mlic_core/sensors/rig.h"

namespace mlic {

// The frame that the rig file expects of a sensor, empty where it leaves that open, and the messages' own.
struct SensorFrame {
  std::string name;
  std::string expected;
  std::string found;
};

// Of the rig's LiDARs, then its cameras.
std::vector<SensorFrame> FramesOf(const Rig& rig, const std::vector<std::string>& lidar_frames,
                                  const std::vector<std::string>& camera_frames);

// Places of sensors whose messages carry each other's expected frames: their topics look exchanged.
std::vector<std::pair<std::size_t, std::size_t>> ExchangedFrames(const std::vector<SensorFrame>& sensors);

// For people: that the topics of two sensors look exchanged.
std::string LookExchanged(const std::string& a, const std::string& b);

}  // namespace mlic
