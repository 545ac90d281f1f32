#include "mlic_core/io/content_hash.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <vector>

#include "mlic_core/common/error.h"

namespace mlic {
namespace {

// A bijection of 64 bits that spreads every bit (the finaliser of splitmix64).
std::uint64_t Mix(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
  return z ^ (z >> 31);
}

}  // namespace

ContentHash& ContentHash::Add(const void* data, std::size_t size) {
  const char* at = static_cast<const char*>(data);
  for (std::size_t left = size; left > 0;) {
    const std::size_t step = std::min<std::size_t>(left, 8);
    std::uint64_t word = 0;
    std::memcpy(&word, at, step);
    state_ = Mix(state_ ^ word) + 0x9E3779B97F4A7C15ull;
    at += step;
    left -= step;
  }
  state_ = Mix(state_ ^ (size + 0xD1B54A32D192ED03ull));
  return *this;
}

ContentHash& ContentHash::AddContent(const std::filesystem::path& path) {
  constexpr std::uintmax_t kSample = 1 << 16;  // from: structural
  constexpr std::uintmax_t kSamples = 16;      // from: structural
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  std::ifstream stream(path, std::ios::binary);
  if (error || !stream) throw InputError(path.string() + ": no such file, or it cannot be read");
  Add(&size, sizeof(size));
  std::vector<char> sample(static_cast<std::size_t>(std::min(size, kSample)));
  for (std::uintmax_t k = 0; k < kSamples; ++k) {
    stream.seekg(static_cast<std::streamoff>((size - sample.size()) * k / (kSamples - 1)));
    stream.read(sample.data(), static_cast<std::streamsize>(sample.size()));
    if (!stream) throw InputError(path.string() + ": cannot be read to its end");
    Add(sample.data(), sample.size());
  }
  return *this;
}

ContentHash& ContentHash::AddFile(const std::filesystem::path& path) {
  AddContent(path);
  std::error_code error;
  const auto modified = std::filesystem::last_write_time(path, error).time_since_epoch().count();
  return Add(&modified, sizeof(modified));
}

std::uint64_t ContentHash::Value() const { return Mix(state_); }

std::string ContentHash::Text() const {
  char text[17];
  std::snprintf(text, sizeof(text), "%016llx", static_cast<unsigned long long>(Value()));
  return text;
}

}  // namespace mlic
