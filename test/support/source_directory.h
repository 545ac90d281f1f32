#pragma once

#include <string>

namespace mlic {

// The folder of the repository that the tests were built from, without a slash at its end.
std::string SourceDirectory();

}  // namespace mlic
