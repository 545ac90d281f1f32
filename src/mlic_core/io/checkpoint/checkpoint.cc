#include "mlic_core/io/checkpoint/checkpoint.h"

#include <cstdint>
#include <fstream>

#include "mlic_core/io/content_hash.h"
#include "mlic_core/io/text_file.h"

namespace mlic {
namespace {

// The head of a file: what follows is `size` bytes with this checksum, saved under a key with this hash.
struct Header {
  char magic[8] = {'M', 'L', 'I', 'C', 'S', 'T', 'G', '1'};
  std::uint64_t key = 0;
  std::uint64_t size = 0;
  std::uint64_t checksum = 0;
};

std::uint64_t HashOf(const void* data, std::size_t size) { return ContentHash().Add(data, size).Value(); }

}  // namespace

bool CheckpointStore::Load(const std::string& stage, const std::string& key, std::vector<char>* bytes) const {
  std::error_code error;
  const std::uintmax_t file_size = std::filesystem::file_size(FileOf(stage), error);
  std::ifstream stream(FileOf(stage), std::ios::binary);
  Header header;
  if (error || !stream.read(reinterpret_cast<char*>(&header), sizeof(header))) return false;
  if (std::string(header.magic, 8) != std::string(Header().magic, 8)) return false;
  if (header.key != HashOf(key.data(), key.size()) || file_size - sizeof(header) != header.size) return false;
  bytes->resize(header.size);
  if (!stream.read(bytes->data(), static_cast<std::streamsize>(header.size))) return false;
  return HashOf(bytes->data(), bytes->size()) == header.checksum;
}

bool CheckpointStore::Has(const std::string& stage) const {
  std::error_code error;
  return std::filesystem::exists(FileOf(stage), error);
}

void CheckpointStore::Save(const std::string& stage, const std::string& key,
                           const std::vector<char>& bytes) const {
  Header header;
  header.key = HashOf(key.data(), key.size());
  header.size = bytes.size();
  header.checksum = HashOf(bytes.data(), bytes.size());
  std::string content(reinterpret_cast<const char*>(&header), sizeof(header));
  content.append(bytes.data(), bytes.size());
  WriteFileAtomically(FileOf(stage), content);
}

void CheckpointStore::Clear() const {
  std::error_code error;
  std::vector<std::filesystem::path> stages;
  for (const auto& entry : std::filesystem::directory_iterator(directory_, error)) {
    if (entry.path().extension() == ".stage") stages.push_back(entry.path());
  }
  for (const std::filesystem::path& stage : stages) std::filesystem::remove(stage, error);
}

}  // namespace mlic
