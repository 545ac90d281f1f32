#pragma once

#include <vector>

#include "mlic_core/pipeline/stage_store.h"

namespace mlic {

// What a StageStore keeps, as bytes; as of serialize.h.
std::vector<char> ToBytes(const DriveOdometry& odometry);
std::vector<char> ToBytes(const Initialization& start);
std::vector<char> ToBytes(const Adjustment& adjustment);  // as StageStore keeps it
std::vector<char> ToBytes(const ImageFeatures& features);
std::vector<char> ToBytes(const TrackSet& tracks);
std::vector<char> ToBytes(const CameraInitialization& cameras);  // without landmarks and information

// False, with the object unspecified, when the bytes are not exactly one such object.
bool FromBytes(const std::vector<char>& bytes, DriveOdometry* odometry);
bool FromBytes(const std::vector<char>& bytes, Initialization* start);
bool FromBytes(const std::vector<char>& bytes, Adjustment* adjustment);
bool FromBytes(const std::vector<char>& bytes, ImageFeatures* features);
bool FromBytes(const std::vector<char>& bytes, TrackSet* tracks);
bool FromBytes(const std::vector<char>& bytes, CameraInitialization* cameras);

}  // namespace mlic
