#pragma once

#include <string>
#include <vector>

namespace mlic {

inline std::string Joined(const std::vector<std::string>& words, const char* separator = ", ") {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : separator) + word;
  return text;
}

}  // namespace mlic
