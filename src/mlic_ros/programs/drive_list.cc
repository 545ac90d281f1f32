#include "mlic_ros/programs/drive_list.h"

#include <algorithm>
#include <iterator>
#include <set>
#include <sstream>

#include "mlic_core/common/error.h"
#include "mlic_core/io/text_file.h"
#include "mlic_ros/programs/path_list.h"

namespace mlic {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostParts = 64;  // of a path; from: guard

// The last parts of the bag's path without its extension, with _ between them.
std::string NameWithFolders(const fs::path& bag, std::size_t parts) {
  const fs::path whole = fs::absolute(bag).lexically_normal().replace_extension();
  const std::vector<fs::path> all(std::next(whole.begin()), whole.end());
  std::string name;
  for (std::size_t i = all.size() - std::min(parts, all.size()); i < all.size(); ++i) {
    name += (name.empty() ? "" : "_") + all[i].string();
  }
  return name;
}

// With as few folders as tell them apart, the same number for all.
void NameDrives(const fs::path& list, std::vector<ListedDrive>* drives) {
  std::set<std::string> names;
  for (std::size_t parts = 1; names.size() < drives->size(); ++parts) {
    if (parts > kMostParts)
      throw InputError(list.string() + ": two drives cannot be told apart by their paths");
    names.clear();
    for (ListedDrive& drive : *drives) {
      drive.name = NameWithFolders(drive.bags.front(), parts);
      names.insert(drive.name);
    }
  }
}

}  // namespace

std::vector<ListedDrive> ReadDriveList(const fs::path& list) {
  std::istringstream lines(ReadFile(list));
  std::vector<ListedDrive> drives;
  std::set<fs::path> seen;
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    const std::string where = list.string() + ", line " + std::to_string(number) + ": ";
    const std::size_t first = line.find_first_not_of(" \t\r");
    if (first == std::string::npos || line[first] == '#') continue;
    const std::string text = line.substr(first, line.find_last_not_of(" \t\r") + 1 - first);
    ListedDrive drive;
    for (const std::string& path : SplitPaths(text, list.parent_path())) {
      drive.bags.push_back(list.parent_path() / path);
      if (!fs::exists(drive.bags.back())) {
        throw InputError(where + drive.bags.back().string() + ": no such file");
      }
    }
    if (!seen.insert(fs::canonical(drive.bags.front()).replace_extension()).second) {
      throw InputError(where + drive.bags.front().string() +
                       ": is in the list already; expected each drive once");
    }
    drives.push_back(std::move(drive));
  }
  if (drives.empty()) {
    throw InputError(list.string() + ": names no drive; expected the path of one bag on each line");
  }
  NameDrives(list, &drives);
  return drives;
}

}  // namespace mlic
