#include "mlic_core/inspection/finding.h"

#include <algorithm>

#include "mlic_core/ingest/drive_notes.h"

namespace mlic {

Grade WorstGrade(const Findings& findings) {
  Grade worst = Grade::kPass;
  for (const Finding& finding : findings) worst = std::max(worst, finding.grade);
  return worst;
}

std::size_t CountOf(const Findings& findings, Grade grade) {
  return static_cast<std::size_t>(
      std::count_if(findings.begin(), findings.end(), [&](const Finding& f) { return f.grade == grade; }));
}

std::string FindingLine(const Finding& finding) {
  static const char* const kNames[] = {"PASS", "WARN", "FAIL"};
  std::string line = std::string(kNames[static_cast<int>(finding.grade)]) + "  " + finding.subject + ": " +
                     finding.check + ": " + finding.measured;
  if (!finding.limit.empty()) line += " (limit: " + finding.limit + ")";
  if (finding.grade != Grade::kPass && !finding.remedy.empty()) line += "; to do: " + finding.remedy;
  return line;
}

void Append(const Findings& more, Findings* findings) {
  findings->insert(findings->end(), more.begin(), more.end());
}

std::string PlacesText(const std::vector<double>& seconds) {
  constexpr std::size_t kMost = 3;  // from: structural
  std::string text = "at ";
  for (std::size_t i = 0; i < std::min(kMost, seconds.size()); ++i) {
    text += (i == 0 ? "" : ", ") + Number(seconds[i], "%.2f") + " s";
  }
  if (seconds.size() > kMost) text += " and " + std::to_string(seconds.size() - kMost) + " more";
  return text;
}

}  // namespace mlic
