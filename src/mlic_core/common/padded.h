#pragma once

#include <string>

namespace mlic {

// For columns of a table: with spaces behind to the width, and at least one.
inline std::string Padded(const std::string& text, std::size_t width) {
  return text + std::string(text.size() < width ? width - text.size() : 1, ' ');
}

}  // namespace mlic
