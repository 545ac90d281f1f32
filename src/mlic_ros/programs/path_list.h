#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace mlic {

// Paths with blanks between them, relative ones from the directory on. Words that make the name of a file
// together are one path: names may hold blanks.
std::vector<std::string> SplitPaths(const std::string& text, const std::filesystem::path& directory);

}  // namespace mlic
