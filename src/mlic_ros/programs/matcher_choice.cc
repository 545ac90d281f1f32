#include "mlic_ros/programs/matcher_choice.h"

#include "mlic_core/camera/learned/learned_matcher.h"
#include "mlic_core/common/error.h"

namespace mlic {

std::shared_ptr<const FeatureMatcher> ChooseMatcher(const std::string& name, const std::string& weights) {
  if (name == "classical") {
    if (weights.empty()) return nullptr;
    throw InputError("weights of a matcher are given, but the matcher is the classical one: say learned too");
  }
  if (name != "learned") throw InputError("matcher " + name + ": expected classical or learned");
  if (weights.empty()) {
    throw InputError(
        "the learned matcher needs its networks: give their directory as --matcher-weights DIR (launch file: "
        "matcher_weights:=DIR), see docs/learned_matcher.md");
  }
  LearnedMatcherOptions options;
  options.weights = weights;
  return MakeLearnedMatcher(options);
}

}  // namespace mlic
