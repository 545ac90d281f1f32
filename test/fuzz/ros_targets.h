#pragma once

#include <string>

namespace mlic {

// Messages of a bag by their bytes: what is refused ends in an InputError of one line. Of clouds,
// FaultOfCloud must say so beforehand: a std::logic_error where the two differ.
void FuzzPointCloud2(const std::string& bytes);
void FuzzLivox(const std::string& bytes);
void FuzzImage(const std::string& bytes);
void FuzzCompressedImage(const std::string& bytes);
void FuzzImu(const std::string& bytes);

}  // namespace mlic
