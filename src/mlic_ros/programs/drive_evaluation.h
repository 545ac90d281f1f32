#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "mlic_core/common/progress.h"
#include "mlic_ros/programs/evaluation.h"

namespace mlic {

// Methods of calibration that `evaluate` sets beside each other; joint is the calibration that is given.
constexpr const char* kJointMethod = "joint";
constexpr const char* kHandEyeMethod = "hand_eye";
constexpr const char* kPairwiseMethod = "pairwise";

struct DriveEvaluationOptions {
  std::filesystem::path bag, calibration;
  std::filesystem::path truth, rig;  // empty: none
  std::string reference_topic;       // empty: none
  std::vector<std::string> methods;  // of those above; rivals calibrate anew, and need `rig`
};

// `evaluate --bag`: a calibration on the drive that it comes from. InputError as the files say.
Evaluation EvaluateDrive(const DriveEvaluationOptions& options, const CancellationToken& cancellation);

}  // namespace mlic
