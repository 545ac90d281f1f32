#pragma once

#include <set>
#include <string>
#include <utility>
#include <vector>

#include "mlic_core/io/result/robot_model.h"
#include "mlic_core/result/result.h"

namespace mlic {

// Relates a robot's model to a calibration. One link of the calibration stays where the model has it: that of
// the IMU (or CalibrationResult::root), else of the first sensor that the model has; where links of the
// calibration hang at each other, the one that carries the others. InputError where the model has none.
class ModelPlacement {
 public:
  ModelPlacement(const RobotModel& model, const CalibrationResult& calibration);

  // The link that stays.
  const std::string& Anchor() const { return anchor_; }
  // T_root_link, with the sensors where the calibration has them. InputError where the model does not have
  // the link, or a joint between it and all sensors moves.
  RigidTransform InRoot(const std::string& link) const;

 private:
  RigidTransform PoseOf(const std::string& frame) const;

  const RobotModel& model_;
  std::vector<std::pair<std::string, RigidTransform>> calibrated_;  // frame, T_root_frame
  std::set<std::string> links_;                                     // the frames that the model has
  std::string anchor_;
};

// What a merge did, each the names of frames.
struct MergedFrames {
  std::string stayed;
  std::vector<std::string> updated, appended;
};

// Puts the calibration into the model: fixed joints of its frames that the model has get their place, in
// their own parents; frames that it lacks are added below `parent`, by default the IMU's link or else the one
// that stays.
MergedFrames MergeInto(const CalibrationResult& calibration, const std::string& parent, RobotModel* model);

}  // namespace mlic
