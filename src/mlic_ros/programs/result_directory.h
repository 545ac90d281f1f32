#pragma once

#include <filesystem>
#include <functional>

namespace mlic {

// Calls write(DIR/.partial) and moves what it made into DIR, in place of the results of an earlier run, of
// which nothing is left (a refused run after a trusted one leaves no launch file). When write throws, DIR
// stays as it was.
void ReplaceResults(const std::filesystem::path& directory,
                    const std::function<void(const std::filesystem::path&)>& write);

}  // namespace mlic
