#pragma once

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <exception>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "mlic_core/common/error.h"

namespace mlic {

// Sound bytes changed as damaged and hostile files are: bits turned, numbers made extreme, parts cut off,
// taken out, doubled, and exchanged between the sound ones. The same sequence in every run.
class Mutator {
 public:
  explicit Mutator(std::vector<std::string> seeds) : seeds_(std::move(seeds)) {}

  std::string Next() {
    std::string bytes = seeds_[Below(seeds_.size())];
    for (std::size_t changes = 1 + Below(4); changes > 0 && !bytes.empty(); --changes) Change(&bytes);
    return bytes;
  }

 private:
  std::size_t Below(std::size_t limit) { return random_() % limit; }

  void Change(std::string* bytes) {
    const std::size_t at = Below(bytes->size()), length = 1 + Below(std::min<std::size_t>(32, bytes->size()));
    switch (Below(7)) {
      case 0:
        (*bytes)[at] = static_cast<char>((*bytes)[at] ^ (1 << Below(8)));
        break;
      case 1:
        (*bytes)[at] = static_cast<char>(random_());
        break;
      case 2:
        WriteNumber(at, bytes);
        break;
      case 3:
        bytes->resize(at);
        break;
      case 4:
        bytes->erase(at, length);
        break;
      case 5:
        bytes->insert(Below(bytes->size()), bytes->substr(at, length));
        break;
      default:
        const std::string& other = seeds_[Below(seeds_.size())];
        bytes->insert(at, other.substr(Below(other.size()), length));
    }
  }

  void WriteNumber(std::size_t at, std::string* bytes) {
    constexpr std::uint64_t kNumbers[] = {
        0, 1, 0x7f, 0xff, 0xffff, 0x7fffffff, 0x80000000, 0xffffffff, 1ULL << 32, 0x7fffffffffffffff, ~0ULL};
    const std::uint64_t number = kNumbers[Below(sizeof(kNumbers) / sizeof(kNumbers[0]))];
    const std::size_t size = std::min<std::size_t>(std::size_t{1} << Below(4), bytes->size() - at);
    std::memcpy(&(*bytes)[at], &number, size);
  }

  std::vector<std::string> seeds_;
  std::mt19937 random_{1};
};

// The most memory that the process has taken, bytes.
inline std::size_t PeakMemory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::size_t>(usage.ru_maxrss) * 1024;
}

// read takes each of the seeds (one at least) and of `count` mutants, or refuses it by an InputError of one
// line, with memory in proportion.
inline void ReadMutants(const std::vector<std::string>& seeds, int count,
                        const std::function<void(const std::string&)>& read) {
#ifdef __SANITIZE_ADDRESS__
  constexpr std::size_t kMost = 2048u << 20;  // AddressSanitizer keeps what was freed for a while
#else
  constexpr std::size_t kMost = 256u << 20;  // bytes; the seeds are of kilobytes
#endif
  Mutator mutator(seeds);
  const std::size_t before = PeakMemory();
  const int given = static_cast<int>(seeds.size());
  bool any_read = false;
  for (int i = -given; i < count; ++i) {  // below zero: a seed
    try {
      read(i < 0 ? seeds[static_cast<std::size_t>(i + given)] : mutator.Next());
      any_read |= i < 0;
    } catch (const InputError& error) {
      ASSERT_EQ(std::string(error.what()).find('\n'), std::string::npos)
          << "mutant " << i << ": " << error.what();
    } catch (const std::exception& error) {
      FAIL() << "mutant " << i << ": " << error.what();
    }
    ASSERT_LT(PeakMemory(), before + kMost) << "mutant " << i;
  }
  EXPECT_TRUE(any_read) << "no seed is sound";
}

}  // namespace mlic
