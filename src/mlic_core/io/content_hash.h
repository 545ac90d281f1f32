#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace mlic {

// A 64-bit hash of everything added to it, eight bytes a step; against accidents, not against attacks. Each
// Add also counts its length in, so that ("ab", "c") and ("a", "bc") differ.
class ContentHash {
 public:
  ContentHash& Add(const void* data, std::size_t size);
  ContentHash& Add(const std::string& text) { return Add(text.data(), text.size()); }
  // Size and a megabyte in parts spread over the file, of a smaller one all: enough to know a recording by,
  // whatever its size, also where it is copied. InputError when the file cannot be read.
  ContentHash& AddContent(const std::filesystem::path& path);
  // The same and the modification time: whether it was touched since.
  ContentHash& AddFile(const std::filesystem::path& path);

  std::uint64_t Value() const;
  std::string Text() const;  // 16 hexadecimal digits

 private:
  std::uint64_t state_ = 0x6d6c69635f686173ull;
};

}  // namespace mlic
