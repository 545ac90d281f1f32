#pragma once

#include <string>

#include "mlic_core/inspection/finding.h"

namespace mlic {

// The finding of that check; one with the check "absent" where there is none.
inline Finding FindingOf(const Findings& findings, const std::string& check) {
  for (const Finding& finding : findings) {
    if (finding.check == check) return finding;
  }
  Finding none;
  none.check = "absent";
  return none;
}

}  // namespace mlic
