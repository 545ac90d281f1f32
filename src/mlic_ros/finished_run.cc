#include "mlic_ros/finished_run.h"

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <sstream>
#include <vector>

#include "mlic_core/common/error.h"
#include "mlic_core/io/rig_file.h"
#include "mlic_core/io/text_file.h"

namespace mlic {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kSampleBytes = 1 << 16;
constexpr int kSamples = 16;  // spread over a bag

// FNV-1a, 64 bits.
void Hash(const std::string& text, std::uint64_t& hash) {
  for (const char c : text) {
    hash ^= static_cast<unsigned char>(c);
    hash *= 0x100000001b3ull;
  }
  hash ^= text.size() + 1;
  hash *= 0x100000001b3ull;
}

std::string SizeAndTime(const fs::path& path) {
  return std::to_string(fs::file_size(path)) + " " +
         std::to_string(fs::last_write_time(path).time_since_epoch().count());
}

void HashBag(const fs::path& path, std::uint64_t& hash) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw InputError("bag " + path.string() + ": no such file, or it cannot be read");
  Hash(fs::absolute(path).string() + " " + SizeAndTime(path), hash);
  const std::uintmax_t size = fs::file_size(path);
  std::string sample(kSampleBytes, '\0');
  for (int i = 0; i < kSamples; ++i) {
    file.clear();
    file.seekg(static_cast<std::streamoff>(size / kSamples * static_cast<std::uintmax_t>(i)));
    file.read(sample.data(), static_cast<std::streamsize>(sample.size()));
    Hash(sample.substr(0, static_cast<std::size_t>(file.gcount())), hash);
  }
}

// Every file of the directory but the log and what lies under stages.
std::string ListResults(const fs::path& directory) {
  std::vector<std::string> lines;
  for (auto at = fs::recursive_directory_iterator(directory); at != fs::recursive_directory_iterator();
       ++at) {
    if (at->path() == directory / "stages") at.disable_recursion_pending();
    if (!at->is_regular_file() || at->path() == directory / "log.txt") continue;
    lines.push_back(fs::relative(at->path(), directory).string() + " " + SizeAndTime(at->path()) + "\n");
  }
  std::sort(lines.begin(), lines.end());
  std::string text;
  for (const std::string& line : lines) text += line;
  return text;
}

fs::path NoteOf(const fs::path& directory) { return directory / "stages" / "finished.txt"; }

}  // namespace

std::string InputKey(const JobOptions& options) {
  std::uint64_t hash = 0xcbf29ce484222325ull;
  try {
    Hash(SizeAndTime(fs::read_symlink("/proc/self/exe")), hash);
    Hash(ReadFile(options.rig), hash);
    for (const CameraConfig& camera : LoadRigFile(options.rig).cameras) {
      const fs::path mask = options.rig.parent_path() / camera.mask;
      if (!camera.mask.empty() && fs::exists(mask)) Hash(SizeAndTime(mask), hash);
    }
    for (const fs::path& bag : options.bags) HashBag(bag, hash);
  } catch (const fs::filesystem_error& error) {
    throw InputError(error.path1().string() + ": cannot be read (" + error.code().message() + ")");
  }
  Hash(std::to_string(options.load.start), hash);
  Hash(options.load.duration ? std::to_string(*options.load.duration) : "all", hash);
  Hash(std::to_string(static_cast<int>(options.calibration.intrinsics)), hash);
  if (options.calibration.matcher) Hash(options.calibration.matcher->Name(), hash);
  std::ostringstream text;
  text << std::hex << hash;
  return text.str();
}

std::optional<JobOutcome> FindFinishedRun(const fs::path& directory, const std::string& key) {
  std::ifstream file(NoteOf(directory));
  std::string found_key, verdict, refusal;
  std::getline(file, found_key);
  std::getline(file, verdict);
  std::getline(file, refusal);
  if (!file || found_key != key) return std::nullopt;
  std::ostringstream results;
  results << file.rdbuf();
  try {
    if (results.str() != ListResults(directory)) return std::nullopt;
  } catch (const fs::filesystem_error&) {
    return std::nullopt;
  }
  return JobOutcome{verdict == "trusted", refusal};
}

void NoteFinishedRun(const fs::path& directory, const std::string& key, const JobOutcome& outcome) {
  WriteFileAtomically(NoteOf(directory), key + "\n" + (outcome.trusted ? "trusted" : "refused") + "\n" +
                                             outcome.refusal + "\n" + ListResults(directory));
}

}  // namespace mlic
