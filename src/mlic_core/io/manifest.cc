#include "mlic_core/io/manifest.h"

#include <algorithm>
#include <fstream>
#include <sstream>

#include "mlic_core/common/error.h"
#include "mlic_core/io/content_hash.h"
#include "mlic_core/io/text_file.h"

namespace mlic {
namespace {

namespace fs = std::filesystem;

const char* const kFormat = "mlic_manifest/1";

// Empty for a file that cannot be read: no entry has that hash.
std::string HashOfFile(const fs::path& path) {
  std::error_code error;
  std::ifstream stream(path, std::ios::binary);
  if (!stream || !fs::is_regular_file(path, error)) return "";
  ContentHash hash;
  std::vector<char> part(1 << 20);
  while (stream.read(part.data(), static_cast<std::streamsize>(part.size())) || stream.gcount() > 0) {
    hash.Add(part.data(), static_cast<std::size_t>(stream.gcount()));
  }
  return stream.bad() ? "" : hash.Text();
}

// A damaged or foreign manifest must not lead to files outside the folder.
bool StaysInside(const fs::path& path) {
  return !path.empty() && path.is_relative() &&
         std::none_of(path.begin(), path.end(), [](const fs::path& part) { return part == ".."; });
}

}  // namespace

bool Manifest::IsAsWritten(const fs::path& directory, const std::string& path) const {
  const auto is_listed = [&](const std::string& hash) {
    return std::any_of(entries.begin(), entries.end(),
                       [&](const ManifestEntry& entry) { return entry.path == path && entry.hash == hash; });
  };
  const std::string hash = HashOfFile(directory / path);
  return !hash.empty() && is_listed(hash);
}

std::string Manifest::Text() const {
  std::string text =
      std::string(kFormat) + " " + program + "\n# Written by MLIC, which replaces these files only.\n";
  for (const ManifestEntry& entry : entries) text += entry.hash + " " + entry.path + "\n";
  return text;
}

std::optional<Manifest> ReadManifest(const fs::path& directory) {
  std::ifstream stream(directory / kManifestName);
  std::string format, line;
  Manifest manifest;
  if (!(stream >> format >> manifest.program) || format != kFormat) return std::nullopt;
  std::getline(stream, line);
  while (std::getline(stream, line)) {
    if (line.empty() || line[0] == '#') continue;
    const std::size_t blank = line.find(' ');
    if (blank == std::string::npos || !StaysInside(line.substr(blank + 1))) return std::nullopt;
    manifest.entries.push_back({line.substr(0, blank), line.substr(blank + 1)});
  }
  return manifest;
}

void WriteManifest(const fs::path& directory, const Manifest& manifest) {
  WriteFileAtomically(directory / kManifestName, manifest.Text());
}

std::vector<ManifestEntry> ListFiles(const fs::path& directory) {
  std::vector<ManifestEntry> entries;
  for (const fs::directory_entry& file : fs::recursive_directory_iterator(directory)) {
    if (!file.is_regular_file()) continue;
    entries.push_back({HashOfFile(file.path()), fs::relative(file.path(), directory).generic_string()});
  }
  std::sort(entries.begin(), entries.end(),
            [](const ManifestEntry& a, const ManifestEntry& b) { return a.path < b.path; });
  return entries;
}

}  // namespace mlic
