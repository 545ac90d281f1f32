#include "mlic_ros/programs/path_list.h"

#include <sstream>

namespace mlic {

namespace fs = std::filesystem;

std::vector<std::string> SplitPaths(const std::string& text, const fs::path& directory) {
  if (fs::exists(directory / text)) return {text};
  std::vector<std::string> paths, words;
  std::istringstream stream(text);
  for (std::string word; stream >> word;) {
    words.push_back(word);
    std::string joined = words.front();
    for (std::size_t i = 1; i < words.size(); ++i) joined += " " + words[i];
    if (!fs::exists(directory / joined)) continue;
    paths.push_back(joined);
    words.clear();
  }
  paths.insert(paths.end(), words.begin(), words.end());
  return paths;
}

}  // namespace mlic
