#include "fuzz/corpus.h"

#include <algorithm>
#include <filesystem>

#include "mlic_core/io/text_file.h"
#include "support/source_directory.h"

namespace mlic {
namespace {

namespace fs = std::filesystem;

fs::path FolderOf(const std::string& target) {
  return fs::path(SourceDirectory()) / "test/fuzz/corpus" / target;
}

}  // namespace

std::string CorpusFile(const std::string& target, const std::string& name) {
  return ReadFile(FolderOf(target) / name);
}

std::vector<std::string> Corpus(const std::string& target) {
  std::vector<std::string> names, contents;
  for (const auto& entry : fs::directory_iterator(FolderOf(target))) names.push_back(entry.path().filename());
  std::sort(names.begin(), names.end());
  for (const std::string& name : names) contents.push_back(CorpusFile(target, name));
  return contents;
}

}  // namespace mlic
