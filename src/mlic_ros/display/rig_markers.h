#pragma once

#include <visualization_msgs/MarkerArray.h>

#include <string>
#include <vector>

#include "mlic/Status.h"

namespace mlic {

// m, by which the rig is drawn: of the sensor, or guess, that is farthest from the IMU.
double RigSize(const std::vector<SensorStatus>& sensors);

// Each found sensor as axes (red x, green y, blue z) with its name, in the IMU's frame, and the IMU's own;
// where the rig file has a guess of it, that in grey, with a line from it to where the sensor is now. Of one
// that is not found the guess alone, its name in grey.
visualization_msgs::MarkerArray MakeRigMarkers(const Status& status, const std::string& imu_frame);

// Takes away all that the topic has shown.
visualization_msgs::MarkerArray NoMarkers(const std::string& frame);

// Stage and progress, or the verdict, as text over the map.
visualization_msgs::MarkerArray MakeOverlay(const Status& status);

}  // namespace mlic
