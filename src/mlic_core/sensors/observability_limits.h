#pragma once

#include <cmath>

namespace mlic {

// A direction whose sigma from the data alone exceeds these is not shown (docs/method.md, section 10).
constexpr double kTranslationLimit = 0.05;             // m; from: definition
constexpr double kRotationLimit = 0.5 * M_PI / 180.0;  // rad; from: definition
constexpr double kTimeLimit = 5e-3;                    // s; from: definition
// s/s, a drift that counts as large: a time of the limit over a minute's half. from: derivation
constexpr double kDriftLimit = kTimeLimit / 30.0;

}  // namespace mlic
