#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace mlic {

// One drive of a fleet: its bags, and a name that can be a folder's.
struct ListedDrive {
  std::string name;
  std::vector<std::filesystem::path> bags;
};

// Each line of the file names the bag of one drive, or its bags with blanks between them; relative paths
// start from the folder of the list. Empty lines and those that begin with # are left out. A drive is called
// as its first bag; where two would have one name, all have as many folders before it as tell them apart.
// InputError for a bag that is not there, two lines with one bag, and a list of no drive.
std::vector<ListedDrive> ReadDriveList(const std::filesystem::path& list);

}  // namespace mlic
