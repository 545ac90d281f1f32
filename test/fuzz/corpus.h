#pragma once

#include <string>
#include <vector>

namespace mlic {

// A file of test/fuzz/corpus/TARGET, which holds one input of that target.
std::string CorpusFile(const std::string& target, const std::string& name);

// All of them, in the order of their names.
std::vector<std::string> Corpus(const std::string& target);

}  // namespace mlic
