#pragma once

#include <string>
#include <vector>

#include "mlic_core/camera/tracks/tracks_from_images.h"
#include "mlic_core/initialization/camera_on_trajectory.h"
#include "mlic_core/initialization/lidar_imu.h"
#include "mlic_core/uncertainty/adjustment.h"

namespace mlic {

// Where finished stages of a run are kept, so that a killed run goes on where it was. Load returns false when
// there is no such stage of the same inputs; the object is then unspecified. A new kind of stage gets its own
// pair of functions. Neither throws for a stage that cannot be read or written.
// Of an Adjustment is kept what one round hands to the next, planes aside, which each round finds anew: Load
// leaves the rest as it is, and the rounds that follow give the same bits as those of a run that was never
// interrupted.
class StageStore {
 public:
  virtual ~StageStore() = default;

  virtual bool Load(const std::string& stage, DriveOdometry* odometry) = 0;
  virtual bool Load(const std::string& stage, Initialization* start) = 0;
  virtual bool Load(const std::string& stage, Adjustment* adjustment) = 0;
  virtual bool Load(const std::string& stage, ImageFeatures* features) = 0;
  virtual bool Load(const std::string& stage, TrackSet* tracks) = 0;
  virtual bool Load(const std::string& stage, CameraInitialization* cameras) = 0;

  virtual void Save(const std::string& stage, const DriveOdometry& odometry) = 0;
  virtual void Save(const std::string& stage, const Initialization& start) = 0;
  virtual void Save(const std::string& stage, const Adjustment& adjustment) = 0;
  virtual void Save(const std::string& stage, const ImageFeatures& features) = 0;
  virtual void Save(const std::string& stage, const TrackSet& tracks) = 0;
  virtual void Save(const std::string& stage, const CameraInitialization& cameras) = 0;
};

}  // namespace mlic
