#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "mlic_core/ingest/drive_builder.h"

namespace mlic {

constexpr TimeNs kDriveStart = 1'700'000'000'000'000'000;

// 3 s of an IMU at 100 Hz on /imu, at rest with z up, and of a LiDAR at 10 Hz on /points; hooks may change
// them.
struct TestMessages {
  TestMessages() {
    for (int i = 0; i < 300; ++i) {
      const TimeNs time = kDriveStart + TimeNs{i} * 10'000'000;
      messages.imu.push_back({time, time, {0.1, 0.0, 0.0}, {0.0, 0.0, 9.81}});
    }
    messages.lidars.resize(1);
    for (int i = 0; i < 30; ++i) messages.lidars[0].push_back(Scan(i));
    lidars.resize(1);
    lidars[0].topic = "/points";
    lidars[0].time_field = "time";
  }

  static ReadScan Scan(int index) {
    ReadScan scan;
    scan.stamp = scan.start = kDriveStart + TimeNs{index} * 100'000'000;
    scan.record_time = scan.stamp + 100'000'000;
    for (int i = 0; i < 10; ++i) {
      LidarPoint point;
      // Farther than an own body reaches, and never twice in one place.
      point.position = {20.0f + 0.1f * static_cast<float>(index), static_cast<float>(i), 1.0f};
      point.time = 0.01f * static_cast<float>(i);
      scan.scan.points.push_back(point);
    }
    return scan;
  }

  Drive Build() {
    notes = {};
    return BuildDrive(messages, "/imu", lidars, cameras, notes);
  }

  DriveMessages messages;
  std::vector<LidarFormat> lidars;
  std::vector<ImageFormat> cameras;
  DriveNotes notes;
};

inline bool IsNoted(const std::vector<std::string>& lines, const std::string& part) {
  return std::any_of(lines.begin(), lines.end(),
                     [&](const std::string& line) { return line.find(part) != std::string::npos; });
}

}  // namespace mlic
