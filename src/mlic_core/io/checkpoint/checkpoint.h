#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace mlic {

// Finished stages of a run, one file for each stage under a directory (DIR/stages). A stage is found again
// only under the key it was saved with, which names everything it was computed from (ContentHash). Anything
// else, a file cut short or changed too, counts as absent: the stage is then computed again.
class CheckpointStore {
 public:
  explicit CheckpointStore(std::filesystem::path directory) : directory_(std::move(directory)) {}

  bool Load(const std::string& stage, const std::string& key, std::vector<char>* bytes) const;
  // Something was saved for the stage, under whatever key.
  bool Has(const std::string& stage) const;
  // Replaces what the stage had, whole or not at all. InputError when it cannot be written.
  void Save(const std::string& stage, const std::string& key, const std::vector<char>& bytes) const;
  // Forgets all stages (--fresh).
  void Clear() const;

 private:
  std::filesystem::path FileOf(const std::string& stage) const { return directory_ / (stage + ".stage"); }
  std::filesystem::path directory_;
};

}  // namespace mlic
