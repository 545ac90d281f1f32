#pragma once

#include <string>
#include <vector>

#include "mlic_core/ingest/stamped_imu.h"

namespace mlic {

// The readings of a message: 0 to 2 are the gyroscope's x, y, z, 3 to 5 the accelerometer's.
constexpr int kImuAxes = 6;  // from: structural

// Sample: StampedImu or ImuSample.
template <typename Sample>
double AxisReading(const Sample& sample, int axis) {
  return axis < 3 ? sample.angular_velocity[axis] : sample.specific_force[axis - 3];
}

// "gyroscope x".
std::string AxisName(int axis);

// All functions: samples in order of stamps; one flag for each.

// Readings that repeat the one before exactly, on all axes, for a tenth of a second or longer: of a driver
// that hangs.
std::vector<bool> FindFrozen(const std::vector<StampedImu>& samples);

// Readings of one axis at the end of its range: the largest or smallest value comes often, and much more
// often than the next one. In the noise of quantised readings it is the rarest.
std::vector<bool> FindSaturated(const std::vector<StampedImu>& samples, int axis);

// Single readings of one sensor, gyroscope or accelerometer, that are far off both neighbours: of a broken
// transmission. No rig turns or shakes so from one sample to the next and back.
std::vector<bool> FindSpikes(const std::vector<StampedImu>& samples, bool of_gyroscope);

// Readings of one axis that stay the same for half a second or longer while the other axes of the same sensor
// go on: a part of the sensor has failed.
std::vector<bool> FindFrozenAxis(const std::vector<StampedImu>& samples, int axis);

}  // namespace mlic
