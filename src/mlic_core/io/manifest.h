#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace mlic {

// A file that MLIC wrote: its path in the folder of results, and the hash of its content.
struct ManifestEntry {
  std::string hash;
  std::string path;  // relative to the folder, '/' between its parts, never out of it
};

// What MLIC wrote into a folder of results, kept there as manifest.txt: the mark of a folder that MLIC may
// write into, and the list of the files that it may replace. A path can stand twice: while results are
// replaced, with the old content and with the new one.
struct Manifest {
  std::string program;  // that the results are of, such as "calibrate"
  std::vector<ManifestEntry> entries;

  // The file has content that is listed. False for one that is not there.
  bool IsAsWritten(const std::filesystem::path& directory, const std::string& path) const;
  // As it stands in the file.
  std::string Text() const;
};

inline constexpr const char* kManifestName = "manifest.txt";

// Nothing where there is none, or one that MLIC did not write, or that names files outside the folder.
std::optional<Manifest> ReadManifest(const std::filesystem::path& directory);

void WriteManifest(const std::filesystem::path& directory, const Manifest& manifest);

// All regular files of the directory, those in its folders too, in order of their paths.
std::vector<ManifestEntry> ListFiles(const std::filesystem::path& directory);

}  // namespace mlic
