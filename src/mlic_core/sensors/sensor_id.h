#pragma once

#include <cstddef>

namespace mlic {

// Names one sensor of a rig: its place in Rig::lidars or in Rig::cameras.
struct SensorId {
  enum class Kind { kLidar, kCamera };
  Kind kind = Kind::kLidar;
  std::size_t index = 0;

  bool IsLidar() const { return kind == Kind::kLidar; }
};

constexpr SensorId LidarId(std::size_t index) { return {SensorId::Kind::kLidar, index}; }
constexpr SensorId CameraId(std::size_t index) { return {SensorId::Kind::kCamera, index}; }

// The order of all sensors where they stand in one row (unknowns, sigmas, results): LiDARs, then cameras.
class SensorOrder {
 public:
  SensorOrder() = default;
  SensorOrder(std::size_t lidars, std::size_t cameras) : lidars_(lidars), cameras_(cameras) {}

  std::size_t size() const { return lidars_ + cameras_; }
  std::size_t PlaceOf(SensorId id) const { return id.IsLidar() ? id.index : lidars_ + id.index; }
  // place: less than size().
  SensorId At(std::size_t place) const {
    return place < lidars_ ? LidarId(place) : CameraId(place - lidars_);
  }

 private:
  std::size_t lidars_ = 0, cameras_ = 0;
};

}  // namespace mlic
