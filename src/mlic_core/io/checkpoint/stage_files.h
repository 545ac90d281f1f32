#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "mlic_core/io/checkpoint/checkpoint.h"
#include "mlic_core/pipeline/stage_store.h"

namespace mlic {

// Stages of the calibration as files of a directory (DIR/stages). key names the inputs and the program: what
// was saved under another one, or is damaged, is said by one line and counts as absent. A stage that cannot
// be written is said by one line too, and the run goes on without.
class StageFiles : public StageStore {
 public:
  using Line = std::function<void(const std::string&)>;
  StageFiles(const std::filesystem::path& directory, std::string key, Line line)
      : files_(directory), key_(std::move(key)), line_(std::move(line)) {}

  bool Load(const std::string& stage, DriveOdometry* odometry) override { return LoadAny(stage, odometry); }
  bool Load(const std::string& stage, Initialization* start) override { return LoadAny(stage, start); }
  bool Load(const std::string& stage, Adjustment* adjustment) override { return LoadAny(stage, adjustment); }
  bool Load(const std::string& stage, ImageFeatures* features) override { return LoadAny(stage, features); }
  bool Load(const std::string& stage, TrackSet* tracks) override { return LoadAny(stage, tracks); }
  bool Load(const std::string& stage, CameraInitialization* cameras) override {
    return LoadAny(stage, cameras);
  }

  void Save(const std::string& stage, const DriveOdometry& odometry) override { SaveAny(stage, odometry); }
  void Save(const std::string& stage, const Initialization& start) override { SaveAny(stage, start); }
  void Save(const std::string& stage, const Adjustment& adjustment) override { SaveAny(stage, adjustment); }
  void Save(const std::string& stage, const ImageFeatures& features) override { SaveAny(stage, features); }
  void Save(const std::string& stage, const TrackSet& tracks) override { SaveAny(stage, tracks); }
  void Save(const std::string& stage, const CameraInitialization& cameras) override {
    SaveAny(stage, cameras);
  }

 private:
  template <typename T>
  bool LoadAny(const std::string& stage, T* value);
  template <typename T>
  void SaveAny(const std::string& stage, const T& value);

  CheckpointStore files_;
  std::string key_;
  Line line_;
};

}  // namespace mlic
