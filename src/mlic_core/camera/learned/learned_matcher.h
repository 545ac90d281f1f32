#pragma once

#include <filesystem>
#include <memory>

#include "mlic_core/camera/features/feature_matcher.h"
#include "mlic_core/camera/learned/learned_detection.h"

namespace mlic {

// SuperPoint with LightGlue or SuperGlue, from networks that the user brings: their licences forbid to ship
// them. docs/learned_matcher.md says where they come from and what they must look like.
struct LearnedMatcherOptions {
  // Directory with superpoint.onnx and lightglue.onnx or superglue.onnx (ONNX Runtime), or the same names
  // with .pt (TorchScript, libtorch). Where there are several: ONNX before TorchScript, LightGlue before
  // SuperGlue.
  std::filesystem::path weights;
  LearnedDetectionOptions detection;
  float least_score = 0.1f;  // of a match, 0 to 1; from: paper, LightGlue (Lindenberger 2023)
};

// Throws InputError, one line, where this build has no runtime for networks, where files are missing, cannot
// be read or have another signature.
std::unique_ptr<FeatureMatcher> MakeLearnedMatcher(const LearnedMatcherOptions& options);

}  // namespace mlic
