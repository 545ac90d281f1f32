#pragma once

#include <string>
#include <vector>

namespace mlic {

// kWarn: the calibration runs and may lose accuracy or a part of the data. kFail: it would be refused, lose
// the sensor, or be wrong.
enum class Grade { kPass, kWarn, kFail };

// One thing that was looked at in a recording before anything is calibrated. Texts for people, without line
// breaks: measured and limit with their units, remedy empty for a pass.
struct Finding {
  Grade grade = Grade::kPass;
  std::string subject;  // sensor or topic, "drive", "machine"
  std::string check;    // a few words, such as "gaps"
  std::string measured;
  std::string limit;
  std::string remedy;
};

using Findings = std::vector<Finding>;

// kPass for none.
Grade WorstGrade(const Findings& findings);

std::size_t CountOf(const Findings& findings, Grade grade);

// "WARN  lidar: gaps: 2 of 1.3 s in all (limit: none over 0.5 s); to do: ...".
std::string FindingLine(const Finding& finding);

void Append(const Findings& more, Findings* findings);

// "at 12.3 s, 40.1 s, 55.0 s and 7 more": times in seconds after the drive's first message.
std::string PlacesText(const std::vector<double>& seconds);

}  // namespace mlic
