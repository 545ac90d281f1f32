#include "mlic_core/io/output_directory.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>

#include "mlic_core/common/error.h"
#include "mlic_core/io/content_hash.h"

namespace mlic {
namespace {

namespace fs = std::filesystem;

const char* const kPartialName = ".mlic_partial";
const char* const kResultName = "calibration.yaml";
constexpr std::size_t kMostNames = 3;  // of foreign files in a message; from: structural

struct Remover {
  fs::path path;
  ~Remover() {
    std::error_code ignored;
    fs::remove_all(path, ignored);
  }
};

InputError Refusal(const fs::path& directory, const std::string& what) {
  return InputError("output directory " + directory.string() + ": " + what);
}

// What lies in the folder besides the traces of a run that was killed before it left its mark.
std::vector<std::string> NamesIn(const fs::path& directory) {
  std::vector<std::string> names;
  for (const fs::directory_entry& entry : fs::directory_iterator(directory)) {
    const std::string name = entry.path().filename().string();
    if (name != kLockName && name != kPartialName) names.push_back(name);
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::string ForeignFiles(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size() && i < kMostNames; ++i) text += (i > 0 ? ", " : "") + names[i];
  if (names.size() > kMostNames) text += " and " + std::to_string(names.size() - kMostNames) + " more";
  return text;
}

// Waits until the file's content, or the folder's list of names, is on the disk: a power failure must not
// leave names of empty files.
void Sync(const fs::path& path) {
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return;
  fsync(descriptor);
  close(descriptor);
}

bool Lists(const Manifest& manifest, const std::string& path) {
  return std::any_of(manifest.entries.begin(), manifest.entries.end(),
                     [&](const ManifestEntry& entry) { return entry.path == path; });
}

// A name beside the file that is free.
fs::path NameToKeep(const fs::path& file) {
  for (int number = 1;; ++number) {
    const fs::path name = file.string() + ".kept" + (number > 1 ? std::to_string(number) : "");
    if (!fs::exists(fs::symlink_status(name))) return name;
  }
}

}  // namespace

void OutputDirectory::Check(const fs::path& directory, const std::string& program) {
  try {
    if (!fs::exists(directory)) return;
    if (!fs::is_directory(directory)) {
      throw Refusal(directory, "is a file; choose another with --output");
    }
    const std::vector<std::string> names = NamesIn(directory);
    const std::optional<Manifest> manifest = ReadManifest(directory);
    if (!manifest && !names.empty()) {
      throw Refusal(directory, "holds files that MLIC did not write (" + ForeignFiles(names) +
                                   "; no manifest.txt of an earlier run); give an empty or a new folder "
                                   "with --output");
    }
    if (!manifest) return;
    if (manifest->program != program) {
      throw Refusal(directory, "holds results of " + manifest->program + "; " + program +
                                   " needs a folder of its own: choose another with --output");
    }
    for (const ManifestEntry& entry : manifest->entries) {
      if (!fs::exists(directory / entry.path) || manifest->IsAsWritten(directory, entry.path)) continue;
      throw Refusal(directory, entry.path + " was changed since " + program +
                                   " wrote it; move it elsewhere, or choose another folder with --output");
    }
  } catch (const fs::filesystem_error& error) {
    throw Refusal(directory, "cannot be read (" + error.code().message() + "); choose another with --output");
  }
}

OutputDirectory::OutputDirectory(const fs::path& directory, const std::string& program)
    : directory_(directory) {
  Check(directory, program);
  std::error_code error;
  made_ = fs::create_directories(directory, error);
  if (error) {
    throw Refusal(directory, "cannot be written (" + error.message() + "); choose another with --output");
  }
  lock_ = std::make_unique<DirectoryLock>(directory);
  Check(directory, program);  // another process may have written in between
  manifest_ = ReadManifest(directory).value_or(Manifest{program, {}});
  WriteManifest(directory, manifest_);
  fs::remove_all(directory / kPartialName, error);
}

OutputDirectory::~OutputDirectory() {
  std::error_code ignored;
  bool empty = true;
  const fs::directory_iterator end;
  for (fs::directory_iterator at(directory_, ignored); !ignored && at != end; at.increment(ignored)) {
    empty = empty && (at->path().filename() == kManifestName || at->path().filename() == kLockName);
  }
  if (empty) fs::remove(directory_ / kManifestName, ignored);
  lock_.reset();
  if (empty && made_) fs::remove(directory_, ignored);
}

std::string OutputDirectory::ResultsHash() const {
  if (manifest_.entries.empty()) return "";
  for (const ManifestEntry& entry : manifest_.entries) {
    if (!manifest_.IsAsWritten(directory_, entry.path)) return "";
  }
  return ContentHash().Add(manifest_.Text()).Text();
}

std::vector<std::string> OutputDirectory::Replace(const std::function<void(const fs::path&)>& write) {
  const Remover partial{directory_ / kPartialName};
  std::vector<std::string> kept;
  try {
    fs::remove_all(partial.path);
    fs::create_directories(partial.path);
    write(partial.path);
    Publish(partial.path, Manifest{manifest_.program, ListFiles(partial.path)}, &kept);
  } catch (const fs::filesystem_error& error) {
    throw Refusal(directory_, error.code().message() + "; free space or choose another with --output");
  }
  return kept;
}

void OutputDirectory::Publish(const fs::path& partial, const Manifest& fresh,
                              std::vector<std::string>* kept) {
  for (const ManifestEntry& entry : fresh.entries) Sync(partial / entry.path);
  // Whenever the process is killed from here on, all that it leaves is listed.
  const Manifest before = manifest_;
  manifest_.entries.insert(manifest_.entries.end(), fresh.entries.begin(), fresh.entries.end());
  WriteManifest(directory_, manifest_);
  const auto remove = [&](const std::string& path) {
    if (before.IsAsWritten(directory_, path)) fs::remove(directory_ / path);
  };
  remove(kResultName);
  for (const ManifestEntry& entry : before.entries) {
    if (!Lists(fresh, entry.path)) remove(entry.path);
  }
  const auto move = [&](const std::string& path) {
    const fs::path target = directory_ / path;
    if (fs::exists(fs::symlink_status(target)) && !before.IsAsWritten(directory_, path)) {
      const fs::path name = NameToKeep(target);
      fs::rename(target, name);
      kept->push_back(target.string() + " was not written by MLIC: it is kept as " +
                      name.filename().string());
    }
    fs::create_directories(target.parent_path());
    fs::rename(partial / path, target);
  };
  for (const ManifestEntry& entry : fresh.entries) {
    if (entry.path != kResultName) move(entry.path);
  }
  if (Lists(fresh, kResultName)) move(kResultName);
  for (const ManifestEntry& entry : before.entries) {
    const fs::path folder = fs::path(entry.path).parent_path();
    std::error_code ignored;  // one that holds somebody else's files stays
    if (!folder.empty()) fs::remove(directory_ / folder, ignored);
  }
  Sync(directory_);
  manifest_ = fresh;
  WriteManifest(directory_, manifest_);
}

}  // namespace mlic
