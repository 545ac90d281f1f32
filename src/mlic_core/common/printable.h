#pragma once

#include <algorithm>
#include <string>

namespace mlic {

// Text of a file or message within one of our lines: what would end the line or steer a terminal becomes '?'.
inline std::string Printable(std::string text) {
  const auto steers = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; };
  std::replace_if(text.begin(), text.end(), steers, '?');
  return text;
}

}  // namespace mlic
