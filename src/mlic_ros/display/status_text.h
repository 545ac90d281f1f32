#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "mlic/Status.h"

namespace mlic {

// What overlay and panel say of /mlic/status in the same words.

// Whether the transform of a sensor in this state (SensorStatus) says where it is.
bool IsFound(std::uint8_t state);

// In capitals: "RUNNING", "TRUSTED".
std::string VerdictWord(const Status& status);
// Red, green, blue, 0 to 1, on a dark ground.
std::array<float, 3> VerdictColour(const Status& status);
// "stage 4 of 12: joint adjustment"; once it has ended, the verdict.
std::string StageLine(const Status& status);
// "round 3 of 9 is shown"; empty where it is the latest state.
std::string ShownRoundLine(const Status& status);
// "35 %, about 7 min left"
std::string ProgressLine(const Status& status);

}  // namespace mlic
