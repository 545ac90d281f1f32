#pragma once

#include <string>
#include <vector>

#include "mlic_core/association/plane_association.h"
#include "mlic_core/camera/tracks/tracks_from_images.h"
#include "mlic_core/initialization/camera_on_trajectory.h"
#include "mlic_core/initialization/lidar_imu.h"
#include "mlic_core/result/result.h"

namespace mlic {

// What the refinement hands from one round to the next, planes aside, which each round finds anew. From here
// on a later run gives the same bits as one that was never interrupted.
struct RefinementProgress {
  CalibrationState state;
  std::vector<ImuSigma> imu_sigma;                  // of each drive, as measured last
  std::vector<PlaneNoise> noise;                    // of each LiDAR, likewise
  std::vector<LandmarkNoise> landmark_noise;        // of each camera, likewise
  std::vector<FixedCameraParameters> camera_fixed;  // of each camera
  std::vector<PoseSigma> sigmas;                    // of each camera against the base LiDAR
  std::vector<double> match_noise;                  // of each camera
  std::vector<LandmarkSet> landmarks;               // of each drive, with the map's
  int rounds = 0;                                   // of the joint adjustment, done
  std::size_t points_per_scan = 0;                  // that take part in the map
  std::vector<std::string> lines;                   // what the stage has said so far
  std::vector<LandmarkSet> held_out;                // of each drive: matches that no solve used
};

// Where finished stages of a run are kept, so that a killed run goes on where it was. Load returns false when
// there is no such stage of the same inputs; the object is then unspecified. A new kind of stage gets its own
// pair of functions. Neither throws for a stage that cannot be read or written.
class StageStore {
 public:
  virtual ~StageStore() = default;

  virtual bool Load(const std::string& stage, DriveOdometry* odometry) = 0;
  virtual bool Load(const std::string& stage, Initialization* start) = 0;
  virtual bool Load(const std::string& stage, RefinementProgress* progress) = 0;
  virtual bool Load(const std::string& stage, ImageFeatures* features) = 0;
  virtual bool Load(const std::string& stage, TrackSet* tracks) = 0;
  virtual bool Load(const std::string& stage, CameraInitialization* cameras) = 0;

  virtual void Save(const std::string& stage, const DriveOdometry& odometry) = 0;
  virtual void Save(const std::string& stage, const Initialization& start) = 0;
  virtual void Save(const std::string& stage, const RefinementProgress& progress) = 0;
  virtual void Save(const std::string& stage, const ImageFeatures& features) = 0;
  virtual void Save(const std::string& stage, const TrackSet& tracks) = 0;
  virtual void Save(const std::string& stage, const CameraInitialization& cameras) = 0;
};

// Keeps nothing.
class NoStageStore : public StageStore {
 public:
  bool Load(const std::string&, DriveOdometry*) override { return false; }
  bool Load(const std::string&, Initialization*) override { return false; }
  bool Load(const std::string&, RefinementProgress*) override { return false; }
  bool Load(const std::string&, ImageFeatures*) override { return false; }
  bool Load(const std::string&, TrackSet*) override { return false; }
  bool Load(const std::string&, CameraInitialization*) override { return false; }
  void Save(const std::string&, const DriveOdometry&) override {}
  void Save(const std::string&, const Initialization&) override {}
  void Save(const std::string&, const RefinementProgress&) override {}
  void Save(const std::string&, const ImageFeatures&) override {}
  void Save(const std::string&, const TrackSet&) override {}
  void Save(const std::string&, const CameraInitialization&) override {}
};

}  // namespace mlic
