#pragma once

#include <memory>
#include <string>

#include "mlic_core/camera/features/feature_matcher.h"

namespace mlic {

// The matcher that the user names: "classical" (null: the default one) or "learned", with the directory of
// its networks. Throws InputError for other names, and where the learned one cannot be made.
std::shared_ptr<const FeatureMatcher> ChooseMatcher(const std::string& name, const std::string& weights);

}  // namespace mlic
