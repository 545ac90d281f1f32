// One of libFuzzer's programs: MLIC_FUZZ_TARGET of MLIC_FUZZ_HEADER.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include MLIC_FUZZ_HEADER
#include "mlic_core/common/error.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    mlic::MLIC_FUZZ_TARGET(std::string(data, data + size));
  } catch (const mlic::InputError& error) {
    if (std::string(error.what()).find('\n') != std::string::npos) std::abort();
  }
  return 0;
}
